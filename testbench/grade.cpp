// Drives a design of which every lane is another variant: all get the same inputs, and
// each is compared with lane 0 at every clock.
//
// goldtof_lanes.h is written beside the verilated model for the design at hand: it
// names inputs, outputs and registers. A plane is a word that holds one bit of every
// lane; the choice planes say which variant each lane is.

#include "goldtof_lanes.h"
#include "process.h"

namespace {

// What the caller asks for; goldtof's lanes/variants.rs has the same. The first argument
// is the place of what belongs to it in the shared file.
enum What : uint64_t { LOAD = 0, SAVE = 1, CHOOSE = 2, RUN = 3 };

// The further arguments of RUN: number of clocks, and the place of what is found. That
// is a plane of the lanes that differed, and for each lane the first clock at which it
// did. Then the place of the skips, and their number: before such a clock the scan's
// counters are moved on.
struct Skip {
    uint64_t clock;
    uint64_t chips;
    uint64_t groups;
};

void run(LANES_MODEL* top, const uint64_t* records, uint64_t clocks, uint64_t* found,
         const Skip* skip, uint64_t skips) {
    const Skip* const last = skip + skips;
    auto& root = *top->rootp;
    uint64_t different = 0;
    for (uint64_t clock = 0; clock < clocks; ++clock) {
        for (; skip != last && skip->clock == clock; ++skip) {
            lanes_skip(root, skip->chips, skip->groups);
        }
        lanes_apply(root, records);
        records += LANES_RECORD_WORDS;
        top->LANES_CLOCK ^= 1;
        top->eval();
        uint64_t fresh = lanes_differ(root) & ~different;
        different |= fresh;
        for (; fresh != 0; fresh &= fresh - 1) found[1 + __builtin_ctzll(fresh)] = clock;
    }
    found[0] = different;
}

}  // namespace

static void serve(uint64_t* words, int /*number*/) {
    VerilatedContext context;
    // Never deleted: the process ends instead, and nothing of it is wanted then.
    LANES_MODEL* top = new LANES_MODEL{&context};
    top->LANES_CLOCK = 0;
    top->eval();
    answer(OK, "");
    Request request;
    while (next(request)) {
        uint64_t* const at = words + request.arguments[0];
        switch (request.what) {
        case LOAD: lanes_load(*top->rootp, at); break;
        case SAVE: lanes_save(*top->rootp, at); break;
        case CHOOSE: lanes_choose(*top->rootp, at); break;
        case RUN:
            run(top, at, request.arguments[1], words + request.arguments[2],
                reinterpret_cast<const Skip*>(words + request.arguments[3]), request.arguments[4]);
            break;
        default: ::_exit(1);
        }
        answer(OK, "");
    }
}
