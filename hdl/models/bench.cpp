// A board among hostile surroundings: what is at its pins, at its line, and (core_bench.sv) in the place of
// its core comes from files, and so goes what came of it.
//
//   bench SEED SENDS READS CHIPS [FIRST]
//
//   SEED         of all that is random
//   SENDS READS  length of the host's bits, in bits of BAUD, when it sends and reads
//   CHIPS        of the run, and until all was said; in the bench the most of them: it ends when all was said and
//                offered, and the line is silent
//   FIRST        with the board's own core: the sample that is the first one of photons.bin
//
// Reads   host.txt     "byte HH", "bits N" (idle for so many bits), "until N" (up to bit N of the run), "low N" (a break),
//                      "flags N" (o_overrun, o_saturated), "light N" (0: the detectors are dark, 1: light at random, 2: a hit of each sample
//                      every three chips), "slow N" (1: registers take their time), "unlock N" (the PLL loses its
//                      lock for so many bits), "answer HHHHHHHH N" (idle until the answer to the request with these
//                      four bytes, the first one lowest, has been heard, for N bits at most), one a line
//         results.txt  a line for each result: clocks to wait, data (hexadecimal, words of 32 bits, the
//                      lowest first), last
// Writes  line.bin     bytes of the line
//         axi.txt      transfers: "R" or "W", address, data, response
//         report.txt   "key value" a line: what follows from the run; "reset" with the bytes, results taken and
//                      transfers before it; "hits" by sample before each light but the first dark, and at the end
//
// Ends with status 1 and a line "fault WHAT" in report.txt where a rule is broken: of AXI4-Lite (what is offered stands until it is
// taken; nothing is offered in reset), of the reset, or when samples, lasers or the LED are not what they
// have to be. LED_ON and HELD are levels; CORE_BENCH says that the core is core_bench.sv, whose results have TDATA_BITS.

#include <algorithm>
#include <cmath>
#include <deque>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "simulated_board.h"
#ifdef CORE_BENCH
#include "svdpi.h"
#endif

namespace {

double chip_now = 0, chips_of_bit = 0;

// What the user's Verilog prints is not part of it.
std::ofstream report{"report.txt"};

[[noreturn]] void fault(const std::string& what) {
    report << "fault at chip " << uint64_t(chip_now) << ": " << what << std::endl;
    std::exit(1);
}

uint32_t random_state;
uint32_t random_number() {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state;
}

// Hits by sample at the core.
void report_hits();

// What a host hears: bits in the middle of their time, by its own clock. What it says: levels, and how long
// they stand.
struct Script : Line {
    Script(double sends, double reads) : sent_bit(sends), read_bit(reads) {}

    double sent_bit, read_bit;
    std::ofstream out{"line.bin", std::ios::binary};
    bool busy = false, before = true;
    double next = 0;
    int slot = 0;
    unsigned byte = 0;
    double first = 0, last = 0, settled = 4;
    uint64_t broken = 0, bytes = 0;

    std::ifstream in{"host.txt"};
    std::deque<std::pair<int, double>> levels;  // level, bits
    double until = 0, unlocked_until = 0;
    int level = 1, flags = 0, light = 1;
    bool slow = false, done = false;

    // An answer repeats its request in bytes 4 to 7, and ends with its CRC.
    static constexpr int ANSWER_BYTES = 16, IDENTITY_BYTES = 44, HEAD_BYTES = 8;
    uint64_t heard = 0;  // the last eight bytes, the first one lowest
    uint32_t answered = 0, awaited = 0;
    double answered_until = 0;
    bool awaits = false;

    void hears() {
        heard = heard >> 8 | uint64_t(byte) << 56;
        const uint8_t sync = heard, kind = heard >> 8;
        if (sync != 0xa5 || (kind != 'A' && kind != 'I')) return;
        answered = heard >> 32;
        // And some bits of rest.
        answered_until = last + 10.3 * ((kind == 'A' ? ANSWER_BYTES : IDENTITY_BYTES) - HEAD_BYTES) + 2;
        if (awaits && answered == awaited) until = answered_until;
    }

    void takes(double bit, bool is_high) override {
        // The line is anything until the first reset, which is over by chip 64, and some clocks of the line later.
        if (chip_now < 64) settled = bit + 4;
        if (bit < settled) return;
        if (!busy && before && !is_high) {
            busy = true;
            slot = 0;
            byte = 0;
            next = bit + read_bit / 2;
        }
        before = is_high;
        if (!busy || bit < next) return;
        next += read_bit;
        // As of a reset: a receiver takes it for noise.
        if (slot == 0 && is_high) {
            broken++;
            busy = false;
            return;
        }
        if (slot >= 1 && slot <= 8) byte |= unsigned(is_high) << (slot - 1);
        if (slot == 9) {
            busy = false;
            if (first == 0) first = bit;
            last = bit;
            if (is_high) {
                out.put(char(byte));
                bytes++;
                hears();
            } else {
                broken++;
            }
        }
        slot++;
    }

    bool sends(double bit) override {
        while (bit >= until) {
            if (levels.empty() && !say(bit)) {
                done = true;
                return true;
            }
            if (levels.empty()) continue;
            level = levels.front().first;
            until = (until == 0 ? bit : until) + levels.front().second;
            levels.pop_front();
        }
        return level;
    }

    // The next line of what there is to say.
    bool say(double bit) {
        std::string word;
        awaits = false;
        if (!(in >> word)) return false;
        double number;
        if (word == "answer") {
            in >> std::hex >> awaited >> std::dec >> number;
            awaits = answered != awaited;
            levels.push_back({1, awaits ? number : std::max(answered_until - bit, 0.0)});
            return true;
        }
        if (word == "byte") {
            unsigned value;
            in >> std::hex >> value >> std::dec;
            levels.push_back({0, sent_bit});
            for (int place = 0; place < 8; place++) levels.push_back({int(value >> place & 1), sent_bit});
            levels.push_back({1, sent_bit});
            return true;
        }
        in >> number;
        if (word == "until") levels.push_back({1, std::max(number - bit, 0.0)});
        if (word == "bits" || word == "low") levels.push_back({word == "bits", number * sent_bit});
        if (word == "flags") flags = int(number);
        if (word == "light") {
            light = int(number);
            if (light != 0) report_hits();
        }
        if (word == "slow") slow = number != 0;
        if (word == "unlock") unlocked_until = bit + number;
        return true;
    }
};

// The board, and all that is round it.
Script* script;
Board* board;
uint32_t level_now = 0;  // of the pins at the last step
int64_t step_now = 0;
bool locked = false;

#ifdef CORE_BENCH
constexpr int64_t MOST_LAG = 16 * SAMPLES_PER_CHIP;
constexpr uint64_t MOST_LASER_LAG = 16;
constexpr size_t WORDS = (TDATA_BITS + 31) / 32;
// Edges behind a reset after which gears and registers have what came behind it.
constexpr uint64_t SETTLED = 40;

// What core_bench.sv has at its ports: samples that are those of the pins, one constant lag behind; a
// reset that is there when it has to be; and results from a file, held until they are taken.
struct Core {
    std::ifstream file{"results.txt"};
    bool has_next = false, offered = false;
    unsigned wait = 0, waited = 0;
    std::vector<uint32_t> words;
    bool last = false;
    uint64_t stalled = 0;

    uint32_t history[2 * MOST_LAG] = {};  // levels at the pins
    std::vector<int64_t> lags;            // those that are still possible
    uint32_t chips[MOST_LASER_LAG] = {};
    uint64_t chips_made = 0;
    uint32_t may_lag_lasers = (1u << MOST_LASER_LAG) - 1;
    double resumes_at = 0;
    uint64_t anew = 0, taken = 0, transfers = 0;
    bool needs_reset = true, reset_ended = false, edge_in_step = false;
    uint64_t edges = 0, edges_unlocked = 0;  // since the reset; without a lock
    uint64_t flags_since = 0;  // edges with these flags
    int flags = 0;
    int64_t second_edge = 0;
    uint64_t hits[DETECTORS * SAMPLES_PER_CHIP] = {};
    uint32_t before = 0;       // the last level of each detector
    uint32_t lasers_before = 0;
    bool lasers_steady = true;

    Core() {
        // All samples of a chip have to have come.
        for (int64_t lag = SAMPLES_PER_CHIP - 1; lag < MOST_LAG; ++lag) lags.push_back(lag);
        read();
    }

    void read() {
        std::string line;
        has_next = bool(std::getline(file, line));
        if (!has_next) return;
        std::istringstream fields{line};
        fields >> wait >> std::hex;
        words.clear();
        for (uint32_t number; fields >> number;) words.push_back(number);
        last = words.back() != 0;
        words.pop_back();
        waited = 0;
    }

    // Between edges: the lasers' pins stand still.
    void at_pins(const Vsimulated_board& top) {
        lasers_steady = edge_in_step || (lasers_steady && top.o_laser == lasers_before);
        lasers_before = top.o_laser;
    }

    void check_samples(const svBitVecVal* samples) {
        const auto differ = [&](int64_t lag) {
            for (int k = 0; k < DETECTORS * SAMPLES_PER_CHIP; ++k) {
                const int sample = k % SAMPLES_PER_CHIP;
                // The last pin, which has the longest delay, is the first to be seen.
                const int pin = k / SAMPLES_PER_CHIP * PINS + (PINS - 1 - sample % PINS);
                const uint64_t at = uint64_t(step_now - lag + sample) % (2 * MOST_LAG);
                if ((history[at] >> pin & 1) != (samples[k / 32] >> (k % 32) & 1)) return true;
            }
            return false;
        };
        lags.erase(std::remove_if(lags.begin(), lags.end(), differ), lags.end());
        if (lags.empty())
            fault("the samples at the core are not those at the pins, in their order and one constant time later");
        for (int d = 0; d < DETECTORS; ++d) {
            bool high = before >> d & 1;
            for (int k = d * SAMPLES_PER_CHIP; k < (d + 1) * SAMPLES_PER_CHIP; ++k) {
                const bool was_high = high;
                high = (samples[k / 32] >> (k % 32) & 1) != REST;
                hits[k] += high && !was_high;
            }
            before = (before & ~(1u << d)) | uint32_t(high) << d;
        }
    }

    void check_pins(const Vsimulated_board& top) {
        for (uint32_t rest = may_lag_lasers; rest != 0; rest &= rest - 1) {
            const uint64_t lag = __builtin_ctz(rest);
            if (chips[(chips_made - lag) % MOST_LASER_LAG] != lasers_before) may_lag_lasers &= ~(1u << lag);
        }
        if (may_lag_lasers == 0) fault("the lasers' pins are not the core's chips, one constant number of chips later");
        if (!lasers_steady) fault("a laser's pin changes within a chip");
        if (flags_since > SETTLED && bool(top.o_led) != ((flags & 1) != 0 ? !LED_ON : bool(LED_ON)))
            fault("the LED does not tell whether a result has been lost");
        if (bool(top.o_held) != bool(HELD)) fault("what the board has to hold is not held");
    }

    void edge(bool reset, const svBitVecVal* samples, bool ready, svBitVecVal* lasers, svBitVecVal* tdata,
              svBit* tvalid, svBit* tlast) {
        const Vsimulated_board& top = board->top();
        edge_in_step = true;
        if (reset && locked && reset_ended && !needs_reset) fault("the core is reset, and the PLL has its lock");
        // What comes from here on begins anew.
        if (reset && needs_reset && anew++ > 0)
            report << "reset " << script->bytes << " " << taken << " " << transfers << "\n";
        if (reset) needs_reset = false;
        if (!reset && locked && needs_reset) fault("the PLL has its lock anew, and there was no reset");
        if (!reset && !locked && ++edges_unlocked > 4) fault("the PLL has no lock, and the core no reset");
        if (locked) edges_unlocked = 0;
        edges = reset ? 0 : edges + 1;
        reset_ended = locked && !reset;
        if (edges == 2 && second_edge == 0) second_edge = step_now;
        if (edges > SETTLED && locked) {
            check_samples(samples);
            check_pins(top);
        }
        // The flags of the core, and chips that are 0 in reset.
        flags_since = flags == script->flags ? flags_since + 1 : 0;
        flags = reset ? 0 : script->flags;
        uint32_t chips_now = reset ? 0 : random_number();
        for (int m = LASERS; m < 32; ++m) chips_now &= ~(1u << m);
        chips[++chips_made % MOST_LASER_LAG] = chips_now;
        *lasers = chips_now;

        if (!reset && offered) {
            stalled += !ready;
            if (ready) {
                offered = false;
                taken++;
                read();
            }
        }
        if (reset) offered = false;
        // A host that was in the middle of a byte when the reset came has to see the line idle.
        if (reset) resumes_at = chip_now + 12 * chips_of_bit;
        if (!offered && has_next && chip_now >= resumes_at && waited++ >= wait) offered = true;
        *tvalid = offered;
        *tlast = offered ? last : random_number() & 1;
        for (size_t k = 0; k < WORDS; ++k) tdata[k] = offered ? words[k] : random_number();
        tdata[WORDS - 1] &= ~0u >> (32 * WORDS - TDATA_BITS);
    }
};

Core* core;

void report_hits() {
    report << "hits";
    for (uint64_t count : core->hits) report << " " << count;
    report << "\n";
}

// A memory of 512 words that takes its time, and above it addresses that answer SLVERR and DECERR; and the
// rules.
struct Slave {
    std::ofstream out{"axi.txt"};
    std::map<unsigned, uint32_t> words;
    bool have_aw = false, have_w = false, have_ar = false, answered_b = false, answered_r = false;
    unsigned aw = 0, ar = 0;
    uint32_t w = 0;
    bool asked = false, answers_late = false;
    double ready_at = 0, due = 0;  // chips from which on it takes, and answers
    bool was_in_reset = false;  // a reset takes effect with its first edge
    struct Offer {
        bool valid = false;
        bool taken = false;
        uint64_t payload = 0;
    } offers[3];
    // Its outputs.
    bool awready = false, wready = false, bvalid = false, arready = false, rvalid = false;
    uint32_t bresp = 0, rdata = 0, rresp = 0;

    void rule(int channel, bool valid, bool ready, uint64_t payload, bool in_reset) {
        static const char* names[] = {"aw", "w", "ar"};
        Offer& offer = offers[channel];
        if (valid && in_reset && was_in_reset) fault(std::string(names[channel]) + "valid in reset");
        if (offer.valid && !offer.taken && !in_reset) {
            if (!valid) fault(std::string(names[channel]) + "valid fell before it was taken");
            if (payload != offer.payload) fault(std::string(names[channel]) + " changed while it waited");
        }
        offer = {valid && !in_reset, valid && ready, payload};
    }

    static unsigned response(unsigned address) { return address >= 0xc00 ? 3 : address >= 0x800 ? 2 : 0; }

    void edge(bool in_reset, bool awvalid, unsigned awaddr, bool wvalid, uint32_t wdata, unsigned wstrb, bool bready,
              bool arvalid, unsigned araddr, bool rready) {
        rule(0, awvalid, awready, awaddr, in_reset);
        rule(1, wvalid, wready, wdata | uint64_t(wstrb) << 32, in_reset);
        rule(2, arvalid, arready, araddr, in_reset);
        was_in_reset = in_reset;
        if (in_reset) {
            have_aw = have_w = have_ar = false;
            awready = wready = arready = bvalid = rvalid = asked = false;
            return;
        }
        // Now and then the address, or the answer, takes longer than an answer's frame.
        const double late = (100 + random_number() % 200) * chips_of_bit;
        if (!asked && (awvalid || wvalid || arvalid)) {
            asked = true;
            const unsigned mode = script->slow ? random_number() % 2 : random_number() % 8;
            ready_at = chip_now + (mode == 0 ? late : 0);
            answers_late = mode == 1;
        }
        if ((awvalid && awready) || (arvalid && arready)) due = chip_now + (answers_late ? late : random_number() % 8);
        asked = asked && !(bvalid && bready) && !(rvalid && rready);
        if (awvalid && awready) {
            if (have_aw) fault("a second write address before the response");
            have_aw = true;
            aw = awaddr;
        }
        if (wvalid && wready) {
            if (have_w) fault("a second word to write before the response");
            if (wstrb != 15) fault("wstrb is not all ones");
            have_w = true;
            w = wdata;
        }
        if (arvalid && arready) {
            if (have_ar) fault("a second read address before the data");
            have_ar = true;
            ar = araddr;
        }
        if (bvalid && bready) {
            have_aw = have_w = bvalid = false;
        } else if (have_aw && have_w && !bvalid && chip_now >= due) {
            bresp = response(aw);
            if (bresp == 0) words[aw] = w;
            core->transfers++;
            out << "W " << std::hex << aw << " " << w << " " << bresp << std::endl;
            bvalid = true;
        }
        if (rvalid && rready) {
            have_ar = rvalid = false;
        } else if (have_ar && !rvalid && chip_now >= due) {
            rresp = response(ar);
            rdata = words.count(ar) ? words[ar] : 0xdead0000u + ar;
            core->transfers++;
            out << "R " << std::hex << ar << " " << rdata << " " << rresp << std::endl;
            rvalid = true;
        }
        // What is not offered is noise.
        const uint32_t noise = random_number();
        if (!rvalid) {
            rdata = noise;
            rresp = noise >> 16 & 3;
        }
        if (!bvalid) bresp = noise >> 18 & 3;
        const bool takes = chip_now >= ready_at;
        awready = !have_aw && takes && (noise >> 20 & 3) == 0;
        wready = !have_w && takes && (noise >> 22 & 3) == 0;
        arready = !have_ar && takes && (noise >> 24 & 3) == 0;
    }
};

Slave* slave;
#else
void report_hits() {}
#endif

}  // namespace

// Verilog that ends its simulation.
void vl_finish(const char* file, int line, const char*) { fault("$finish at " + std::string(file) + ":" + std::to_string(line)); }
void vl_stop(const char* file, int line, const char*) { fault("$stop at " + std::string(file) + ":" + std::to_string(line)); }
void vl_fatal(const char* file, int line, const char*, const char* what) {
    fault(std::string(what) + " at " + file + ":" + std::to_string(line));
}

#ifdef CORE_BENCH
extern "C" void core_edge(svBit reset, const svBitVecVal* samples, svBit ready, svBitVecVal* lasers,
                          svBitVecVal* tdata, svBit* tvalid, svBit* tlast, svBit* overrun, svBit* saturated) {
    core->edge(reset, samples, ready, lasers, tdata, tvalid, tlast);
    *overrun = core->flags & 1;
    *saturated = core->flags >> 1 & 1;
}

extern "C" void slave_edge(svBit reset, svBit awvalid, const svBitVecVal* awaddr, svBit wvalid,
                           const svBitVecVal* wdata, const svBitVecVal* wstrb, svBit bready, svBit arvalid,
                           const svBitVecVal* araddr, svBit rready, svBit* awready, svBit* wready,
                           svBitVecVal* bresp, svBit* bvalid, svBit* arready, svBitVecVal* rdata,
                           svBitVecVal* rresp, svBit* rvalid) {
    slave->edge(reset, awvalid, *awaddr, wvalid, *wdata, *wstrb, bready, arvalid, *araddr, rready);
    *awready = slave->awready;
    *wready = slave->wready;
    *bresp = slave->bresp;
    *bvalid = slave->bvalid;
    *arready = slave->arready;
    *rdata = slave->rdata;
    *rresp = slave->rresp;
    *rvalid = slave->rvalid;
}
#endif

int main(int argc, char** argv) {
    if (argc < 5) return 2;
    random_state = std::strtoul(argv[1], nullptr, 10) * 2654435761u | 1;
    Script host(std::strtod(argv[2], nullptr), std::strtod(argv[3], nullptr));
    const uint64_t chips = std::strtoull(argv[4], nullptr, 10);
    script = &host;
#ifdef CORE_BENCH
    Core the_core;
    Slave the_slave;
    core = &the_core;
    slave = &the_slave;
#else
    Photons photons("photons.bin");
    const int64_t first = argc > 5 ? std::strtoll(argv[5], nullptr, 10) : 0;
#endif
    // Registers without a value of their own wake with any.
    Board the_board(random_state);
    board = &the_board;

    const double bits_of_step = BAUD / board->sample_hz();
    chips_of_bit = 1 / (bits_of_step * SAMPLES_PER_CHIP);
    double quiet = 0;
#ifdef CORE_BENCH
    double locked_at = 0;
#endif
    for (step_now = 0;; ++step_now) {
        const double bit = double(step_now) * bits_of_step;
        const bool lock = step_now >= LOCKED_AT && bit >= host.unlocked_until;
#ifdef CORE_BENCH
        if (locked && !lock) core->needs_reset = true;
        if (!locked && lock) locked_at = chip_now;
        const bool is_even = step_now % 2 == 0;
        const int64_t chip = step_now / SAMPLES_PER_CHIP % 3;
        if (host.light == 0 || host.light == 2)
            level_now = (host.light == 2 && chip != 2 && is_even == (chip == 0)) == bool(REST) ? 0u : ~0u;
        // Each pin by itself changes with every fourth sample.
        static_assert(DETECTORS * PINS <= 16, "two random bits for each");
        const uint32_t random = host.light == 1 ? random_number() : 0;
        level_now ^= random & random >> 16;
        core->history[uint64_t(step_now) % (2 * MOST_LAG)] = level_now;
        core->edge_in_step = false;
#else
        level_now = photons.levels(step_now - first);
#endif
        locked = lock;
        board->lock(lock);
        chip_now = double(step_now) / SAMPLES_PER_CHIP;
        board->step(level_now, &host);
#ifdef CORE_BENCH
        core->at_pins(board->top());
        if (locked && core->edges == 0 && chip_now - locked_at > 64) fault("the core stays in reset, or without a clock");
        if (chip_now >= double(chips)) fault("the line does not fall silent");
        const bool more = core->has_next || host.busy;
#else
        const bool more = chip_now < double(chips);
#endif
        if (more || !host.done) quiet = bit;
        if (bit - quiet > 400) break;
    }
    report << "chip_fs " << std::llround(1e15 * SAMPLES_PER_CHIP / board->sample_hz()) << "\nchips " << uint64_t(chip_now) << "\nbytes " << host.bytes << "\nbroken " << host.broken
              << "\nbusy_bits " << host.last - host.first << "\n";
#ifdef CORE_BENCH
    report << "stalled " << core->stalled << "\nfirst " << core->second_edge - core->lags.front() << "\n";
    report_hits();
#endif
    return 0;
}
