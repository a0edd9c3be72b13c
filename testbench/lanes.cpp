// Drives a design in lanes: every net is a word, and each of its bits a copy of the
// design of its own.
//
// goldtof_lanes.h is written beside the verilated model for the design at hand: it
// names inputs, outputs and registers. A plane is a word that holds one bit of every
// lane. The caller writes planes of samples, and what the outputs are expected to be;
// they are compared at every clock. Expected planes change where the caller says so
// (events) and, for outputs that follow a code, with every clock (tables).
//
// A clock is: inputs set, one evaluation, outputs compared. Where no lane is in reset
// another clock goes on, that of the design without one.

#include "goldtof_lanes.h"
#include "process.h"

namespace {

// What the caller asks for; goldtof's lanes/model.rs has the same. The first argument
// is the place of what belongs to it in the shared file.
enum What : uint64_t { LOAD = 0, SAVE = 1, EXPECT = 2, TABLES = 3, CHECK = 4 };

struct Table {
    uint64_t output;
    uint64_t length;
    uint64_t at;  // first word
};

struct Event {
    uint64_t clock;   // of the block
    uint64_t output;
    uint64_t flips;
};

struct Block {
    uint64_t clocks;
    uint64_t reset;      // plane of i_rst
    uint64_t watched;    // lanes that are compared
    uint64_t with_code;  // lanes that are not in reset: the others' codes are 0
    uint64_t samples;    // first word of the planes of i_samples
    uint64_t events;     // how many
    uint64_t events_at;  // first word
    uint64_t found_at;   // first word of what is found
    uint64_t phases[LANES_TABLES];  // where each table stands
};

// What is found: lanes that differed, the first clock of the block at which one did,
// number of beats; then the beats, each its clock and all outputs.
enum Found { DIFFERENT = 0, FIRST_CLOCK = 1, BEATS = 2, FIRST_BEAT = 3 };

uint64_t expected[LANES_OUTPUTS];
Table tables[LANES_TABLES];

void check(LANES_MODEL* top, uint64_t* words, const Block& block) {
    const uint64_t* samples = words + block.samples;
    const Event* event = reinterpret_cast<const Event*>(words + block.events_at);
    const Event* const last_event = event + block.events;
    uint64_t* const found = words + block.found_at;
    uint64_t* beat = found + FIRST_BEAT;
    uint64_t different = 0;
    uint64_t first_clock = block.clocks;
    uint64_t beats = 0;
    uint64_t phases[LANES_TABLES];
    for (int i = 0; i < LANES_TABLES; ++i) phases[i] = block.phases[i];
    auto& root = *top->rootp;
    auto& edge = block.reset ? top->LANES_RESET_CLOCK : top->LANES_CLOCK;
    for (uint64_t clock = 0; clock < block.clocks; ++clock) {
        lanes_apply(root, block.reset, samples);
        samples += LANES_SAMPLES;
        edge ^= 1;
        top->eval();
        for (; event != last_event && event->clock == clock; ++event) {
            expected[event->output] ^= event->flips;
        }
        for (int i = 0; i < LANES_TABLES; ++i) {
            const Table& table = tables[i];
            expected[table.output] = words[table.at + phases[i]] & block.with_code;
            if (++phases[i] == table.length) phases[i] = 0;
        }
        const uint64_t differ = lanes_differ(root, expected) & block.watched;
        if (__builtin_expect(differ != 0, 0)) {
            if (different == 0) first_clock = clock;
            different |= differ;
        }
        if (lanes_valid(root) & block.watched) {
            *beat++ = clock;
            lanes_outputs(root, beat);
            beat += LANES_OUTPUTS;
            ++beats;
        }
    }
    found[DIFFERENT] = different;
    found[FIRST_CLOCK] = first_clock;
    found[BEATS] = beats;
}

}  // namespace

static void serve(uint64_t* words, int /*number*/) {
    VerilatedContext context;
    // Never deleted: the process ends instead, and nothing of it is wanted then.
    LANES_MODEL* top = new LANES_MODEL{&context};
    top->LANES_CLOCK = 0;
    top->LANES_RESET_CLOCK = 0;
    top->eval();
    answer(OK, "");
    Request request;
    while (next(request)) {
        uint64_t* const at = words + request.arguments[0];
        switch (request.what) {
        case LOAD: lanes_load(*top->rootp, at); break;
        case SAVE: lanes_save(*top->rootp, at); break;
        case EXPECT: std::memcpy(expected, at, sizeof expected); break;
        case TABLES: std::memcpy(tables, at, sizeof tables); break;
        case CHECK: check(top, words, *reinterpret_cast<const Block*>(at)); break;
        default: ::_exit(1);
        }
        answer(OK, "");
    }
}
