// Every way of using the library wrongly that it can notice: an error with its reason.

#include <stdio.h>
#include <string.h>

#include "goldtof.h"

static int failures = 0;

static void refused(const char *what, int is_refused, const char *reason) {
    if (is_refused && strstr(goldtof_last_error(), reason)) return;
    printf("%s: refused %d, \"%s\" lacks \"%s\"\n", what, is_refused, goldtof_last_error(), reason);
    failures++;
}

// `before`, `part` 30,000 times, `after`: deeper than any stack that followed it part by part.
static const char *deep(const char *before, const char *part, const char *after) {
    static char text[100000];
    char *end = text + sprintf(text, "%s", before);
    for (int i = 0; i < 30000; i++) end += sprintf(end, "%s", part);
    sprintf(end, "%s", after);
    return text;
}

int main(void) {
    const goldtof_status invalid = GOLDTOF_STATUS_INVALID;
    refused("null path", !goldtof_scene_load(NULL), "the path is a null pointer");
    refused("no file", !goldtof_scene_load("/nonexistent/scene.toml"), "cannot read the scene");
    refused("no text", !goldtof_scene_parse("a.toml", NULL), "null pointer");
    refused("no UTF-8", !goldtof_scene_parse("a.toml", "\xff\xfe"), "not UTF-8");
    refused("no scene", !goldtof_scene_parse("a.toml", "x = 1"), "a.toml:1:1");
    refused("null scene", goldtof_scene_set(NULL, "path.distance=5 m") == invalid, "the scene is a null");
    refused("null scene", !goldtof_model_new(NULL, -1, -1), "the scene is a null pointer");
    refused("null model", goldtof_model_words(NULL) == 0, "the model is a null pointer");
    refused("null board", goldtof_scoreboard_word(NULL, 0) == invalid, "the scoreboard is a null");
    refused("null board", goldtof_scoreboard_words(NULL, NULL, 0) == invalid, "the scoreboard is a null");
    refused("null board", !goldtof_scoreboard_report(NULL), "the scoreboard is a null");

    goldtof_scene *scene = goldtof_scene_load("scenes/quick.toml");
    if (!scene) return 1;
    refused("bad key", goldtof_scene_set(scene, "path.length=5 m") == invalid, "length");
    refused("bad value", goldtof_scene_set(scene, "path.distance=5 kg") == invalid, "5 kg");
    refused("no key", goldtof_scene_set(scene, "nothing") == invalid, "no \"=\"");
    refused("deep key", goldtof_scene_set(scene, deep("a", ".a", "=1")) == invalid, "more than 16 parts");
    refused("deep places", goldtof_scene_set(scene, deep("path", "[0]", "=1")) == invalid, "more than 16 parts");
    refused("deep lists", goldtof_scene_set(scene, deep("scan.steps=", "[", "")) == invalid, "scan.steps");
    refused("deep tables", goldtof_scene_set(scene, deep("scan.steps=", "{a=", "")) == invalid, "scan.steps");
    refused("deep file key", !goldtof_scene_parse("a.toml", deep("a", ".a", "=1")), "a.toml:1:");
    refused("deep file table", !goldtof_scene_parse("a.toml", deep("[a", ".a", "]")), "a.toml:1:");
    refused("deep file lists", !goldtof_scene_parse("a.toml", deep("a=", "[", "")), "a.toml:1:");
    if (goldtof_scene_set(scene, "path.distance=5 m") != GOLDTOF_STATUS_OK) failures++;
    refused("latency", !goldtof_model_new(scene, 100000, -1), "at most 4096");
    refused("peak", !goldtof_model_new(scene, -1, 3), "finds no peak");

    goldtof_model *model = goldtof_model_new(scene, -1, -1);
    if (!model) return 1;
    struct goldtof_port port;
    refused("port", goldtof_model_port(model, 99, &port) == invalid, "no output port 99");
    refused("port", goldtof_model_port(model, 0, NULL) == invalid, "null pointer");
    uint64_t samples[2] = {0, 0x100}, outputs[2] = {7, 7};
    refused("samples", goldtof_model_clock(model, 2, NULL, NULL, NULL, outputs) == invalid, "samples");
    refused("outputs", goldtof_model_clock(model, 2, samples, NULL, NULL, NULL) == invalid, "outputs");
    refused("wide", goldtof_model_clock(model, 2, samples, NULL, NULL, outputs) == invalid,
            "clock 1: the sample word of input 0 is 0x100");
    if (outputs[0] != 7 || outputs[1] != 7) failures++;

    refused("batch", !goldtof_scoreboard_new(scene, -1, -1, 1, 0), "at least 1 clock");
    goldtof_scoreboard *board = goldtof_scoreboard_new(scene, -1, -1, 1, 16);
    if (!board) return 1;
    refused("name", goldtof_scoreboard_port(board, NULL, 1) == invalid, "null pointer");
    refused("width", goldtof_scoreboard_port(board, "i_rst", 0) == invalid, "at least 1 bit");
    refused("none", goldtof_scoreboard_begin(board) == 0, "no port i_rst");
    goldtof_scoreboard_port(board, "i_samples", 16);
    refused("width", goldtof_scoreboard_begin(board) == 0,
            "port i_samples has 16 bits in the testbench and 8 in the sensor");
    refused("word", goldtof_scoreboard_word(board, 0) == invalid, "i_samples");
    refused("null words", goldtof_scoreboard_words(board, NULL, 3) == invalid, "words is a null");
    refused("words", goldtof_scoreboard_words(board, NULL, -1) == invalid, "count is -1");
    refused("verdict", goldtof_scoreboard_verdict(board) == invalid, "i_samples");

    goldtof_scoreboard_free(board);
    goldtof_model_free(model);
    goldtof_scene_free(scene);
    goldtof_scene_free(NULL);
    goldtof_model_free(NULL);
    goldtof_scoreboard_free(NULL);
    if (failures) return 1;
    puts("all refused");
    return 0;
}
