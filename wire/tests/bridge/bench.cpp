// Drives a bridge of hdl/bridge/ at its ports: results and an AXI4-Lite slave on one clock, the line on a
// time base of its own. What the host and the source do is in files; so is what came.
//
//   bench CLK_PS UART_CLK_PS HOST_SENDS_PS HOST_READS_PS SEED
//
// Reads   results.txt  a line for each result: clocks to wait, data (hexadecimal, four words of 32 bits at
//                      most, the lowest first), last
//         host.txt     "byte HH", "bits N" (idle for so many bits), "low N" (a break), "flags N" (i_overrun,
//                      i_saturated), "reset", one a line
// Writes  line.bin     bytes of the line
//         axi.txt      transfers: "R" or "W", address, data, response
// Prints  the time in ps between the first and the last byte's ends, clocks that a result waited, and bytes
//         without a stop bit, which are left out
//
// Ends with status 1 and a message where a rule of AXI4-Lite is broken: what is
// offered stands until it is taken; nothing is offered in reset; a response is taken only once.
#include <verilated.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "Vbridge.h"

namespace {

[[noreturn]] void fail(const std::string& what, uint64_t time_ps) {
    std::cout << "at " << time_ps << " ps: " << what << "\n";
    std::exit(1);
}

struct Result {
    unsigned wait;
    std::vector<uint32_t> words;
    bool last;
};

void set_words(CData& port, const std::vector<uint32_t>& words) { port = words[0]; }
void set_words(SData& port, const std::vector<uint32_t>& words) { port = words[0]; }
void set_words(IData& port, const std::vector<uint32_t>& words) { port = words[0]; }
void set_words(QData& port, const std::vector<uint32_t>& words) {
    port = uint64_t(words.size() > 1 ? words[1] : 0) << 32 | words[0];
}
template <size_t N> void set_words(VlWide<N>& port, const std::vector<uint32_t>& words) {
    for (size_t k = 0; k < N; k++) port[k] = k < words.size() ? words[k] : 0;
}

uint32_t random_state;
uint32_t random_number() {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state;
}

// What a host hears: bits in the middle of their time, by its own clock.
struct Listener {
    uint64_t bit_ps;
    std::ofstream out{"line.bin", std::ios::binary};
    bool busy = false;
    uint64_t next_ps = 0;
    int slot = 0;
    unsigned byte = 0;
    uint64_t first_ps = 0, last_ps = 0, broken = 0;
    bool before = true;

    void hear(bool level, uint64_t time_ps) {
        // The line is anything until the first reset.
        if (time_ps < 4 * bit_ps) return;
        if (!busy && before && !level) {
            busy = true;
            slot = 0;
            byte = 0;
            next_ps = time_ps + bit_ps / 2;
        }
        before = level;
        if (!busy || time_ps < next_ps) return;
        next_ps += bit_ps;
        // As of a reset: a receiver takes it for noise.
        if (slot == 0 && level) {
            busy = false;
            return;
        }
        if (slot >= 1 && slot <= 8) byte |= unsigned(level) << (slot - 1);
        if (slot == 9) {
            if (level) {
                out.put(char(byte));
            } else {
                broken++;
            }
            busy = false;
            if (first_ps == 0) first_ps = time_ps;
            last_ps = time_ps;
        }
        slot++;
    }
};

// What a host says: levels and how long they stand.
struct Speaker {
    uint64_t bit_ps;
    std::ifstream in{"host.txt"};
    std::vector<std::pair<int, uint64_t>> levels;  // level (or a command), ps
    size_t at = 0;
    uint64_t until_ps = 0;
    int level = 1, overrun = 0, saturated = 0;
    bool reset = false;

    bool done() const { return at >= levels.size() && !more(); }
    bool more() const { return bool(in) && !in.eof(); }

    void speak(uint64_t time_ps) {
        while (time_ps >= until_ps) {
            if (at >= levels.size()) {
                level = 1;
                levels.clear();
                at = 0;
                std::string word;
                if (!(in >> word)) return;
                if (word == "byte") {
                    unsigned byte;
                    in >> std::hex >> byte >> std::dec;
                    levels.push_back({0, bit_ps});
                    for (int bit = 0; bit < 8; bit++) levels.push_back({int(byte >> bit & 1), bit_ps});
                    levels.push_back({1, bit_ps});
                } else if (word == "bits" || word == "low") {
                    uint64_t bits;
                    in >> bits;
                    levels.push_back({word == "bits", bits * bit_ps});
                } else if (word == "flags") {
                    int flags;
                    in >> flags;
                    overrun = flags & 1;
                    saturated = flags >> 1 & 1;
                } else if (word == "reset") {
                    reset = true;
                }
                continue;
            }
            level = levels[at].first;
            until_ps = (until_ps == 0 ? time_ps : until_ps) + levels[at].second;
            at++;
        }
    }
};

#ifdef AXIL
// A memory of 1,024 words, the upper half of which answers SLVERR, that takes its time; and the rules.
struct Slave {
    std::ofstream out{"axi.txt"};
    std::map<unsigned, uint32_t> words;
    bool have_aw = false, have_w = false, have_ar = false;
    unsigned aw = 0, ar = 0;
    uint32_t w = 0;
    bool was_in_reset = false;  // a reset takes effect with its first edge
    struct Offer {
        bool valid = false;
        bool taken = false;
        uint64_t payload = 0;
    } offers[3];

    void rule(int channel, bool valid, bool ready, uint64_t payload, bool in_reset, uint64_t time_ps) {
        static const char* names[] = {"aw", "w", "ar"};
        Offer& offer = offers[channel];
        if (valid && in_reset && was_in_reset) fail(std::string(names[channel]) + "valid in reset", time_ps);
        if (offer.valid && !offer.taken && !in_reset) {
            if (!valid) fail(std::string(names[channel]) + "valid fell before it was taken", time_ps);
            if (payload != offer.payload) fail(std::string(names[channel]) + " changed while it waited", time_ps);
        }
        offer = {valid && !in_reset, valid && ready, payload};
    }

    // Before a rising edge: what happens at it. After: new inputs.
    void before(Vbridge& top, bool in_reset, uint64_t time_ps) {
        rule(0, top.m_axil_awvalid, top.m_axil_awready, top.m_axil_awaddr, in_reset, time_ps);
        rule(1, top.m_axil_wvalid, top.m_axil_wready, top.m_axil_wdata | uint64_t(top.m_axil_wstrb) << 32, in_reset,
             time_ps);
        rule(2, top.m_axil_arvalid, top.m_axil_arready, top.m_axil_araddr, in_reset, time_ps);
        was_in_reset = in_reset;
        if (in_reset) {
            have_aw = have_w = have_ar = false;
            answered_b = answered_r = false;
            return;
        }
        if (top.m_axil_awvalid && top.m_axil_awready) {
            if (have_aw) fail("a second write address before the response", time_ps);
            have_aw = true;
            aw = top.m_axil_awaddr;
        }
        if (top.m_axil_wvalid && top.m_axil_wready) {
            if (have_w) fail("a second word to write before the response", time_ps);
            if (top.m_axil_wstrb != 15) fail("wstrb is not all ones", time_ps);
            have_w = true;
            w = top.m_axil_wdata;
        }
        if (top.m_axil_arvalid && top.m_axil_arready) {
            if (have_ar) fail("a second read address before the data", time_ps);
            have_ar = true;
            ar = top.m_axil_araddr;
        }
        if (top.m_axil_bvalid && top.m_axil_bready) answered_b = true;
        if (top.m_axil_rvalid && top.m_axil_rready) answered_r = true;
    }

    bool answered_b = false, answered_r = false;

    void after(Vbridge& top, bool in_reset) {
        if (in_reset) {
            top.m_axil_bvalid = top.m_axil_rvalid = 0;
            top.m_axil_awready = top.m_axil_wready = top.m_axil_arready = 0;
            return;
        }
        if (answered_b) {
            answered_b = have_aw = have_w = false;
            top.m_axil_bvalid = 0;
        } else if (have_aw && have_w && !top.m_axil_bvalid && random_number() % 4 == 0) {
            unsigned response = aw >= 0x800 ? 2 : 0;
            if (response == 0) words[aw] = w;
            out << "W " << std::hex << aw << " " << w << " " << response << "\n";
            top.m_axil_bvalid = 1;
            top.m_axil_bresp = response;
        }
        if (answered_r) {
            answered_r = have_ar = false;
            top.m_axil_rvalid = 0;
        } else if (have_ar && !top.m_axil_rvalid && random_number() % 4 == 0) {
            unsigned response = ar >= 0x800 ? 2 : 0;
            uint32_t data = words.count(ar) ? words[ar] : 0xdead0000u + ar;
            out << "R " << std::hex << ar << " " << data << " " << response << "\n";
            top.m_axil_rvalid = 1;
            top.m_axil_rresp = response;
            top.m_axil_rdata = data;
        }
        // What is not offered is noise.
        if (!top.m_axil_rvalid) top.m_axil_rdata = random_number();
        if (!top.m_axil_bvalid) top.m_axil_bresp = random_number() & 3;
        top.m_axil_awready = !have_aw && random_number() % 3 == 0;
        top.m_axil_wready = !have_w && random_number() % 3 == 0;
        top.m_axil_arready = !have_ar && random_number() % 3 == 0;
    }
};
#endif

}  // namespace

int main(int argc, char** argv) {
    if (argc < 6) return 2;
    const uint64_t clk_ps = std::strtoull(argv[1], nullptr, 10);
    const uint64_t uart_ps = std::strtoull(argv[2], nullptr, 10);
    Speaker speaker{std::strtoull(argv[3], nullptr, 10)};
    Listener listener{std::strtoull(argv[4], nullptr, 10)};
    random_state = std::strtoul(argv[5], nullptr, 10) | 1;

    // Registers wake with any value.
    Verilated::randReset(2);
    Verilated::randSeed(int(random_state));
    Vbridge top;

    std::vector<Result> results;
    std::ifstream file{"results.txt"};
    for (std::string line; std::getline(file, line);) {
        std::istringstream fields{line};
        Result result;
        fields >> result.wait >> std::hex;
        std::vector<uint32_t> numbers;
        for (uint32_t number; fields >> number;) numbers.push_back(number);
        result.last = numbers.back() != 0;
        numbers.pop_back();
        result.words = numbers;
        results.push_back(result);
    }

    size_t next = 0;
    unsigned waited = 0;
    uint64_t stalled = 0, quiet_ps = 0;
    int reset_clocks = 1;
#ifdef AXIL
    Slave slave;
    slave.after(top, true);
#endif
    top.i_clk = top.i_uart_clk = 0;
    top.i_rst = 1;
    top.i_rx = 1;
    top.s_axis_tvalid = 0;
    top.eval();

    // The clocks' phases differ.
    uint64_t clk_next = clk_ps, uart_next = uart_ps + uart_ps / 3, time_ps = 0;
    while (true) {
        time_ps = std::min(clk_next, uart_next);
        const bool core_edge = time_ps == clk_next, uart_edge = time_ps == uart_next;
        const bool rises = core_edge && !top.i_clk;
        const bool in_reset = top.i_rst;
        bool taken = false;
        speaker.speak(time_ps);
        top.i_rx = speaker.level;
        if (rises) {
            taken = top.s_axis_tvalid && top.s_axis_tready && !in_reset;
            stalled += top.s_axis_tvalid && !top.s_axis_tready;
#ifdef AXIL
            slave.before(top, in_reset, time_ps);
#endif
        }
        if (core_edge) {
            top.i_clk = !top.i_clk;
            clk_next += clk_ps / 2;
        }
        if (uart_edge) {
            top.i_uart_clk = !top.i_uart_clk;
            uart_next += uart_ps / 2;
        }
        top.eval();
        listener.hear(top.o_tx, time_ps);
        if (rises) {
            if (speaker.reset) {
                speaker.reset = false;
                reset_clocks = 1;
                top.i_rst = 1;
            } else if (reset_clocks > 0 && --reset_clocks == 0) {
                top.i_rst = 0;
            }
            top.i_overrun = speaker.overrun;
            top.i_saturated = speaker.saturated;
            if (taken) {
                next++;
                waited = 0;
                top.s_axis_tvalid = 0;
            }
            if (!top.s_axis_tvalid) {
                if (next < results.size() && !top.i_rst) {
                    if (waited++ >= results[next].wait) {
                        top.s_axis_tvalid = 1;
                        set_words(top.s_axis_tdata, results[next].words);
                        top.s_axis_tlast = results[next].last;
                    }
                } else {
                    set_words(top.s_axis_tdata, {random_number(), random_number(), random_number(), random_number()});
                    top.s_axis_tlast = random_number() & 1;
                }
            }
#ifdef AXIL
            slave.after(top, top.i_rst);
#endif
            top.eval();
        }
        if (listener.busy || next < results.size() || !speaker.done()) quiet_ps = time_ps;
        if (time_ps - quiet_ps > 400 * listener.bit_ps) break;
    }
    top.final();
    std::cout << listener.last_ps - listener.first_ps << " " << stalled << " " << listener.broken << "\n";
}
