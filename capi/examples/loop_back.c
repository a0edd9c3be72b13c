// The laser's code looped back into the detector: a pulse in the word of every chip that is
// one. At phase step 0 the reference has the pulses' own delay, so that it counts every one
// of them up.
//
//     cc -I capi/include capi/examples/loop_back.c -L target/release -lgoldtof_c -o loop_back
//     LD_LIBRARY_PATH=target/release ./loop_back scenes/quick.toml

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "goldtof.h"

enum { RESET_CLOCKS = 2, CLOCKS = 6000, BATCH = 1000, MOST_RESULTS = 8 };

static void fail(void) {
    fprintf(stderr, "error: %s\n", goldtof_last_error());
    exit(2);
}

static struct goldtof_model *new_model(const goldtof_scene *scene) {
    goldtof_model *model = goldtof_model_new(scene, -1, -1);
    if (!model) fail();
    return model;
}

static struct goldtof_port port_of(const goldtof_model *model, const char *name) {
    struct goldtof_port port;
    for (uint32_t i = 0; i < goldtof_model_ports(model); i++) {
        if (goldtof_model_port(model, i, &port) != GOLDTOF_STATUS_OK) fail();
        if (strcmp(port.name, name) == 0) return port;
    }
    fprintf(stderr, "error: there is no port %s\n", name);
    exit(2);
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fprintf(stderr, "usage: loop_back SCENE\n");
        return 2;
    }
    goldtof_scene *scene = goldtof_scene_load(argv[1]);
    if (!scene) fail();
    goldtof_model *dark = new_model(scene), *lit = new_model(scene);
    const size_t words = goldtof_model_words(dark);
    const struct goldtof_port laser = port_of(dark, "o_laser");

    // What the laser shows, without any light.
    static uint64_t samples[CLOCKS + 1];
    static uint8_t reset[CLOCKS];
    memset(reset, 1, RESET_CLOCKS);
    uint64_t *outputs = calloc(CLOCKS * words, sizeof *outputs);
    if (goldtof_model_clock(dark, CLOCKS, samples, reset, NULL, outputs) != GOLDTOF_STATUS_OK)
        fail();
    unsigned long pulses = 0;
    for (size_t clock = 0; clock < CLOCKS; clock++) {
        const uint64_t chip = outputs[clock * words + laser.word] >> laser.shift & 1;
        // The word of a chip is taken one clock after the laser shows it.
        samples[clock + 1] = chip ? 0x3 : 0;
        pulses += chip;
    }
    printf("%lu pulses in %d clocks\n", pulses, CLOCKS);

    // The same clocks with that light, batch by batch.
    for (size_t clock = 0; clock < CLOCKS; clock += BATCH)
        if (goldtof_model_clock(lit, BATCH, samples + clock, reset + clock, NULL,
                                outputs + clock * words) != GOLDTOF_STATUS_OK)
            fail();
    struct goldtof_result results[MOST_RESULTS];
    const size_t found = goldtof_model_take_results(lit, results, MOST_RESULTS);
    for (size_t i = 0; i < found; i++)
        printf("clock %llu: step %llu counts %lld of %llu\n", (unsigned long long)results[i].clock,
               (unsigned long long)results[i].step, (long long)results[i].count,
               (unsigned long long)results[i].total);

    free(outputs);
    goldtof_model_free(dark);
    goldtof_model_free(lit);
    goldtof_scene_free(scene);
    return 0;
}
