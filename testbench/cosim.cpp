// Drives a verilated sensor_top in blocks of clocks.
//
// goldtof_ports.h is written beside the verilated model for the ports at hand: it
// names the model and packs its ports, in the caller's order, into 64-bit words.
// The shared file holds words of a block's inputs, and room for those of its
// outputs.
//
// Inputs change soon after a rising edge, as those of a circuit do. Where goldtof_low.h says that
// outputs can move before the next one they are looked at twice more: when the inputs have
// changed, and when the clock has fallen, which is what a receiver takes. It says how the clock
// falls, too.

#include "goldtof_ports.h"

#include "goldtof_low.h"
#include "goldtof_x.h"
#include "process.h"
#include "verilated_save.h"

bool goldtof_has_read_x = false;

namespace {

int number_of_process = 0;

}  // namespace

// None in the first process, all in the opposite one, and splitmix64's in further ones.
uint64_t goldtof_flips() {
    if (number_of_process < 2) return number_of_process ? ~uint64_t{0} : 0;
    static uint64_t state = static_cast<uint64_t>(number_of_process);
    uint64_t z = state += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
}

namespace {

// What the caller asks for; goldtof's verilated.rs has the same. Arguments: number of
// clocks, first word of the block's place in the shared file, number of skips, what of the state is
// asked for.
enum What : uint64_t { RUN = 0, RUN_BARE = 1, FINISH = 2 };

// Of the state, added up: a hash of it after the block; itself before the block, to be kept, and
// the hash if an x was made use of; to be taken from where another process has kept it.
enum State : uint64_t { HASH = 1, KEEP = 2, TAKE = 4 };

// Between two clocks the scan's counters are moved on; the rest is as it was.
struct Skip {
    uint64_t clock;   // of the block, before its rising edge
    uint64_t chips;   // what goes into the counter of chips
    uint64_t groups;  // into that of groups
};

// A block in the shared file.
struct BlockLayout {
    uint64_t looks_again;  // whether `low` holds anything
    uint64_t state;        // a hash of all that the model holds after the block; 0 if not asked for
    uint64_t may_read_x;   // whether the model has any that it may make use of at any time
    uint64_t has_read_x;   // whether one was made use of in the block
    uint64_t kept_bytes;   // of the state before the block; 0 if there was no room
    uint64_t in[GOLDTOF_BLOCK_CLOCKS * GOLDTOF_IN_WORDS];
    uint64_t out[GOLDTOF_BLOCK_CLOCKS * GOLDTOF_OUT_WORDS];  // after each rising edge
    uint64_t low[GOLDTOF_BLOCK_CLOCKS * GOLDTOF_OUT_WORDS];  // until each rising edge
    Skip skips[GOLDTOF_MOST_SKIPS];
    uint8_t kept[GOLDTOF_STATE_BYTES];
};

// Registers start with pseudo-random values, so that one that no reset reaches is
// seen as a mismatch. The seed is any fixed number, the same in all processes: they differ by
// goldtof_flips().
constexpr int SEED = 1;

// FNV-1a of what Verilator would save of a model.
class StateHash final : public VerilatedSerialize {
public:
    uint64_t value = 0xcbf29ce484222325;
    void flush() override {
        for (const uint8_t* byte = m_bufp; byte != m_cp; ++byte) {
            value = (value ^ *byte) * 0x100000001b3;
        }
        m_cp = m_bufp;
    }
};

// What Verilator would save of a model, into a place that may be too small.
class Keep final : public VerilatedSerialize {
public:
    explicit Keep(uint8_t* to) : m_to{to} {}
    bool fits = true;
    uint64_t bytes = 0;
    void flush() override {
        const uint64_t more = static_cast<uint64_t>(m_cp - m_bufp);
        fits = fits && bytes + more <= GOLDTOF_STATE_BYTES;
        if (fits) std::memcpy(m_to + bytes, m_bufp, more);
        bytes += more;
        m_cp = m_bufp;
    }

private:
    uint8_t* m_to;
};

// The other way.
class Take final : public VerilatedDeserialize {
public:
    explicit Take(const uint8_t* from) : m_from{from} {
        m_endp = m_bufp;
        fill();
    }
    void fill() override {
        const size_t left = static_cast<size_t>(m_endp - m_cp);
        std::memmove(m_bufp, m_cp, left);
        const size_t more = bufferSize() - left;
        const size_t there = GOLDTOF_STATE_BYTES - m_read;
        const size_t taken = more < there ? more : there;
        std::memcpy(m_bufp + left, m_from + m_read, taken);
        m_read += taken;
        m_cp = m_bufp;
        m_endp = m_bufp + left + taken;
    }

private:
    const uint8_t* m_from;
    size_t m_read = 0;
};

uint64_t keep(GOLDTOF_MODEL* top, BlockLayout& place) {
    Keep keep{place.kept};
    keep << *top;
    keep.flush();
    return keep.fits ? keep.bytes : 0;
}

uint64_t state_of(GOLDTOF_MODEL* top) {
    StateHash hash;
    hash << *top;
    hash.flush();
    return hash.value;
}

// Inputs, and the falling edge. Of a bit that has moved with the inputs and back with the clock
// what it has moved to is told.
void look_again(GOLDTOF_MODEL* top, const uint64_t* in, uint64_t* low) {
    uint64_t stood[GOLDTOF_OUT_WORDS], high[GOLDTOF_OUT_WORDS];
    goldtof_sample(top, stood);
    goldtof_apply(top, in);
    top->eval();
    goldtof_sample(top, high);
    goldtof_fall(top);
    top->eval();
    goldtof_sample(top, low);
    for (int word = 0; word < GOLDTOF_OUT_WORDS; ++word) {
        const uint64_t moved = stood[word] ^ high[word];
        low[word] = (high[word] & moved) | (low[word] & ~moved);
    }
}

void run(GOLDTOF_MODEL* top, BlockLayout& place, uint64_t clocks, uint64_t number_of_skips,
         uint64_t state) {
    if (state & TAKE) {
        Take take{place.kept};
        take >> *top;
    }
    place.may_read_x = GOLDTOF_MAY_READ_X;
    place.kept_bytes = GOLDTOF_MAY_READ_X && (state & KEEP) ? keep(top, place) : 0;
    goldtof_has_read_x = false;
    const uint64_t* in = place.in;
    uint64_t* out = place.out;
    uint64_t* low = place.low;
    const Skip* skip = place.skips;
    const Skip* const last_skip = skip + number_of_skips;
    place.looks_again = GOLDTOF_LOOKS_AGAIN;
    for (uint64_t clock = 0; clock < clocks; ++clock) {
        if (GOLDTOF_LOOKS_AGAIN) {
            look_again(top, in, low);
            low += GOLDTOF_OUT_WORDS;
        } else {
            goldtof_apply(top, in);
        }
        for (; skip != last_skip && skip->clock == clock; ++skip) {
            goldtof_skip(top, skip->chips, skip->groups);
        }
        top->GOLDTOF_CLOCK = 1;
        top->eval();
        goldtof_sample(top, out);
        if (!GOLDTOF_LOOKS_AGAIN) goldtof_fall(top);
        in += GOLDTOF_IN_WORDS;
        out += GOLDTOF_OUT_WORDS;
    }
    place.has_read_x = goldtof_has_read_x;
    const bool wants_hash = state & HASH || (state & KEEP && goldtof_has_read_x);
    place.state = wants_hash ? state_of(top) : 0;
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

static void serve(uint64_t* words, int number) {
    number_of_process = number;
    // Nothing between its members differs from process to process.
    static VerilatedContext context;
    context.randReset(2);
    context.randSeed(SEED);
    // Never deleted: the process ends instead, and nothing of it is wanted then.
    GOLDTOF_MODEL* top = new GOLDTOF_MODEL{&context};
    top->GOLDTOF_CLOCK = 0;
    top->eval();
    answer(OK, "");
    Request request;
    while (next(request)) {
        const uint64_t clocks = request.arguments[0], skips = request.arguments[2];
        BlockLayout& place = *reinterpret_cast<BlockLayout*>(words + request.arguments[1]);
        switch (request.what) {
        case RUN: run(top, place, clocks, skips, request.arguments[3]); break;
        case RUN_BARE: run_bare(top, place.in, clocks); break;
        case FINISH: top->final(); break;
        default: ::_exit(1);
        }
        std::fflush(nullptr);
        answer(OK, "");
    }
}

