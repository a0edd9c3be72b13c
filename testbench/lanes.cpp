// Drives a design in lanes: every net is a plane, a word or a vector of LANES_WORDS of them, and
// each of its bits a copy of the design of its own.
//
// goldtof_lanes.h is written for the design at hand: it has the model, of Verilator or in vectors,
// and names its inputs, outputs and registers. The caller says where the detectors' levels change,
// and what the outputs are expected to be; they are compared at every clock. Expected
// planes change where the caller says so (events) and, for outputs that follow a code, with every
// clock (tables).
//
// A clock is: inputs set, one evaluation, outputs compared. Where no lane is in reset
// another clock goes on, that of the design without one.

#include "goldtof_lanes.h"
#include "process.h"

namespace {

// What the caller asks for; goldtof's lanes/model.rs has the same. The first argument
// is the place of what belongs to it in the shared file.
enum What : uint64_t { LOAD = 0, SAVE = 1, EXPECT = 2, TABLES = 3, CHECK = 4 };

struct PeriodicOutput {
    uint64_t output;
    uint64_t length;
    uint64_t at;  // first word
};

// A change in a lane: its place among the planes is place / 64 in words, and place % 64 is its
// bit there.
struct Event {
    uint32_t place;  // of the outputs
    uint32_t clock;  // of the block
};

struct Block {
    uint64_t clocks;
    uint64_t edges;      // how many
    uint64_t edges_at;   // first word of the places, among the samples of the block
    uint64_t events;     // how many
    uint64_t events_at;  // first word
    uint64_t found_at;   // first word of what is found
    Stored reset;        // i_rst
    Stored watched;      // lanes that are compared
    uint64_t phases[LANES_TABLES];  // where each table stands
};

// What is found: the first clock of the block at which a lane differed, number of beats, the
// lanes that differed; then the beats, each its clock and all outputs.
enum Found { FIRST_CLOCK = 0, BEATS = 1, DIFFERENT = 2, FIRST_BEAT = 2 + LANES_WORDS };

typedef uint64_t Word __attribute__((may_alias));

Plane expected[LANES_OUTPUTS];
PeriodicOutput tables[LANES_TABLES];
Stored edges[LANES_CLOCKS * LANES_SAMPLES];

inline void flip(void* planes, uint32_t place) {
    static_cast<Word*>(planes)[place >> 6] ^= uint64_t{1} << (place & 63);
}

void check(LanesRoot& root, uint64_t* words, const Block& block) {
    std::memset(static_cast<void*>(edges), 0, block.clocks * LANES_SAMPLES * sizeof(Stored));
    const uint32_t* edge = reinterpret_cast<const uint32_t*>(words + block.edges_at);
    for (uint64_t i = 0; i < block.edges; ++i) flip(edges, edge[i]);
    const Event* event = reinterpret_cast<const Event*>(words + block.events_at);
    const Event* const last_event = event + block.events;
    uint64_t* const found = words + block.found_at;
    uint64_t* beat = found + FIRST_BEAT;
    Plane different{};
    uint64_t first_clock = block.clocks;
    uint64_t beats = 0;
    uint64_t phases[LANES_TABLES];
    for (int i = 0; i < LANES_TABLES; ++i) phases[i] = block.phases[i];
    const Plane reset = block.reset;
    const Plane watched = block.watched;
    const bool in_reset = any(reset);
    Plane levels[LANES_DETECTORS] = {};
    const Stored* samples = edges;
    for (uint64_t clock = 0; clock < block.clocks; ++clock) {
        lanes_apply(root, reset, levels, samples);
        samples += LANES_SAMPLES;
        lanes_clock(root, in_reset);
        for (; event != last_event && event->clock == clock; ++event) {
            flip(expected, event->place);
        }
        for (int i = 0; i < LANES_TABLES; ++i) {
            const PeriodicOutput& table = tables[i];
            const Stored* planes = reinterpret_cast<const Stored*>(words + table.at);
            // The codes of lanes in reset are 0.
            expected[table.output] = planes[phases[i]] & ~reset;
            if (++phases[i] == table.length) phases[i] = 0;
        }
        const Plane differ = lanes_differ(root, expected) & watched;
        if (__builtin_expect(any(differ), 0)) {
            if (!any(different)) first_clock = clock;
            different |= differ;
        }
        if (any(lanes_valid(root) & watched)) {
            *beat++ = clock;
            lanes_outputs(root, reinterpret_cast<Stored*>(beat));
            beat += LANES_OUTPUTS * LANES_WORDS;
            ++beats;
        }
    }
    found[FIRST_CLOCK] = first_clock;
    found[BEATS] = beats;
    *reinterpret_cast<Stored*>(found + DIFFERENT) = different;
}

}  // namespace

static void serve(uint64_t* words, int /*number*/) {
    LanesRoot& root = lanes_start();
    answer(OK, "");
    Request request;
    while (next(request)) {
        uint64_t* const at = words + request.arguments[0];
        switch (request.what) {
        case LOAD: lanes_load(root, reinterpret_cast<const Stored*>(at)); break;
        case SAVE: lanes_save(root, reinterpret_cast<Stored*>(at)); break;
        case EXPECT: std::memcpy(static_cast<void*>(expected), at, sizeof expected); break;
        case TABLES: std::memcpy(tables, at, sizeof tables); break;
        case CHECK: check(root, words, *reinterpret_cast<const Block*>(at)); break;
        default: ::_exit(1);
        }
        answer(OK, "");
    }
}
