// Drives a verilated sensor_top in blocks of clocks.
//
// goldtof_ports.h is written beside the verilated model for the ports at hand: it
// names the model and packs its ports, in the caller's order, into 64-bit words.
// The shared file holds words of a block's inputs, and room for those of its
// outputs.
//
// A clock is: inputs set, rising edge, outputs read, falling edge. goldtof_clock.h has what
// the falling edge takes: an evaluation, or a note that the clock was low.

#include "goldtof_ports.h"

#include "goldtof_clock.h"
#include "process.h"

namespace {

// What the caller asks for; goldtof's verilated.rs has the same. Arguments: number
// of clocks, first word of the inputs in the shared file, first word of the outputs,
// first word of the skips, number of skips.
enum What : uint64_t { RUN = 0, RUN_BARE = 1, FINISH = 2 };

// Between two clocks the scan's counters are moved on; the rest is as it was.
struct Skip {
    uint64_t clock;   // of the block, before its rising edge
    uint64_t chips;   // what goes into the counter of chips
    uint64_t groups;  // into that of groups
};

// Registers start with pseudo-random values, so that one that no reset reaches is
// seen as a mismatch. The seed is any fixed number.
constexpr int SEED = 1;

void run(GOLDTOF_MODEL* top, const uint64_t* in, uint64_t* out, uint64_t clocks) {
    for (uint64_t clock = 0; clock < clocks; ++clock) {
        goldtof_apply(top, in);
        top->GOLDTOF_CLOCK = 1;
        top->eval();
        goldtof_sample(top, out);
        goldtof_fall(top);
        in += GOLDTOF_IN_WORDS;
        out += GOLDTOF_OUT_WORDS;
    }
}

void run_block(GOLDTOF_MODEL* top, uint64_t* words, const uint64_t* arguments) {
    const uint64_t clocks = arguments[0], number_of_skips = arguments[4];
    const uint64_t* in = words + arguments[1];
    uint64_t* out = words + arguments[2];
    const Skip* skips = reinterpret_cast<const Skip*>(words + arguments[3]);
    uint64_t done = 0;
    for (uint64_t number = 0; number <= number_of_skips; ++number) {
        const bool is_last = number == number_of_skips;
        const uint64_t end = is_last ? clocks : skips[number].clock;
        run(top, in + done * GOLDTOF_IN_WORDS, out + done * GOLDTOF_OUT_WORDS, end - done);
        if (!is_last) goldtof_skip(top, skips[number].chips, skips[number].groups);
        done = end;
    }
}

// The same model and clocks with constant inputs and nothing read, as anybody would write
// it: the yardstick against which co-simulation speed is measured.
void run_bare(GOLDTOF_MODEL* top, const uint64_t* in, uint64_t clocks) {
    goldtof_apply(top, in);
    for (uint64_t clock = 0; clock < clocks; ++clock) {
        top->GOLDTOF_CLOCK = 1;
        top->eval();
        top->GOLDTOF_CLOCK = 0;
        top->eval();
    }
}

}  // namespace

static void serve(uint64_t* words) {
    VerilatedContext context;
    context.randReset(2);
    context.randSeed(SEED);
    // Never deleted: the process ends instead, and nothing of it is wanted then.
    GOLDTOF_MODEL* top = new GOLDTOF_MODEL{&context};
    top->GOLDTOF_CLOCK = 0;
    top->eval();
    answer(OK, "");
    Request request;
    while (next(request)) {
        const uint64_t* const arguments = request.arguments;
        switch (request.what) {
        case RUN: run_block(top, words, arguments); break;
        case RUN_BARE: run_bare(top, words + arguments[1], arguments[0]); break;
        case FINISH: top->final(); break;
        default: ::_exit(1);
        }
        std::fflush(nullptr);
        answer(OK, "");
    }
}

