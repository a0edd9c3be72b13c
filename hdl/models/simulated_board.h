// A board's model and its clocks, for what plays at its pins: simulated_board.cpp, and goldtof's own checks.
//
// Time goes in steps of one sample. The PLL's rates are those of its dividers, as the cells' models give
// them; the host's bits have the length of its own rate, BAUD.

#ifndef SIMULATED_BOARD_H
#define SIMULATED_BOARD_H

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

#include "Vsimulated_board.h"
#include "verilated.h"

// The scene's and the board's numbers come from the Makefile: OSCILLATOR_HZ, BAUD, DETECTORS, PINS (of a
// detector), SAMPLES_PER_CHIP, FAST_CLOCKS (in a chip), and REST, the level of a detector without a pulse.

namespace {

// Of all detectors, a detector's side by side.
constexpr uint32_t ALL_PINS = (1ull << (DETECTORS * PINS)) - 1;

[[noreturn]] void fail(const std::string& what) {
    std::fprintf(stderr, "simulated_board: %s\n", what.c_str());
    std::exit(1);
}

// Pulses of all detectors, in the order of their first samples.
class Photons {
public:
    explicit Photons(const char* path) {
        if (path == nullptr) return;
        file_ = std::strcmp(path, "-") == 0 ? stdin : std::fopen(path, "rb");
        if (file_ == nullptr) fail(std::string("cannot read ") + path + ": " + std::strerror(errno));
        read();
    }

    // Levels of the pins at sample `now` of the scan's; each is asked for once, in order.
    uint32_t levels(int64_t now) {
        while (has_next_ && int64_t(next_.first) <= now) {
            if (next_.detector >= DETECTORS) fail("the pulses are of another scene");
            uint64_t end = next_.first + next_.samples;
            if (end > until_[next_.detector]) until_[next_.detector] = end;
            read();
        }
        uint32_t high = 0;
        for (int d = 0; d < DETECTORS; ++d)
            if (int64_t(until_[d]) > now) high |= ((1u << PINS) - 1) << (d * PINS);
        return REST ? ~high : high;
    }

private:
    struct Record {
        uint64_t first;
        uint32_t samples;
        uint32_t detector;
    };

    void read() { has_next_ = std::fread(&next_, sizeof next_, 1, file_) == 1; }

    std::FILE* file_ = nullptr;
    Record next_ = {};
    bool has_next_ = false;
    uint64_t until_[DETECTORS] = {};
};

// What is at the other end of the line. Moments are in bits of BAUD.
class Line {
public:
    // Takes the level of the line from the board, which has stood up to this moment.
    virtual void takes(double bit, bool level) = 0;
    // The line to the board at a moment.
    virtual bool sends(double bit) = 0;
};

// The board, its clocks, and simulated time in samples.
class Board {
public:
    // Registers without a value of their own wake as 0, as an FPGA's configuration leaves them; or with values
    // that follow from a seed.
    explicit Board(uint32_t seed = 0) : context_(new VerilatedContext) {
        context_->randReset(seed == 0 ? 0 : 2);
        context_->randSeed(int(seed & 0x7fffffff));
        top_.reset(new Vsimulated_board(context_.get()));
        top_->i_fast_clk = top_->i_line_clk = top_->i_step = top_->i_locked = 0;
        top_->i_rx = 1;
        top_->i_detector = REST ? ALL_PINS : 0u;
        top_->eval();
        uint32_t line_multiplier = top_->o_line_divider == 0 ? 1 : top_->o_line_multiplier;
        uint32_t line_divider = top_->o_line_divider == 0 ? 1 : top_->o_line_divider;
        double fast_hz = double(OSCILLATOR_HZ) * top_->o_fast_multiplier / top_->o_fast_divider;
        double line_hz = double(OSCILLATOR_HZ) * line_multiplier / line_divider;
        sample_hz_ = fast_hz / FAST_CLOCKS * SAMPLES_PER_CHIP;
        // Half periods of the line's clock in samples.
        line_step_ = sample_hz_ / (2 * line_hz);
        double delay_ps = 25.0 * top_->o_delay_taps;
        if (PINS > 1 && (delay_ps < 1e12 / sample_hz_ - 12.5 || delay_ps > 1e12 / sample_hz_ + 12.5))
            fail("the delay of a second pin is not one sample");
    }

    double sample_hz() const { return sample_hz_; }
    double now() const { return double(step_); }
    const Vsimulated_board& top() const { return *top_; }

    void lock(bool locked) { top_->i_locked = locked; }

    // One sample, with the detectors' pins at these levels and the host at the line.
    void step(uint32_t levels, Line* host) {
        // The line's clock between the samples.
        while (next_line_ < double(step_)) line_edge(host);
        top_->i_detector = levels & ALL_PINS;
        top_->i_step = step_ & 1;
        if (step_ % STEPS_OF_HALF == 0) top_->i_fast_clk = !top_->i_fast_clk;
        top_->eval();
        ++step_;
    }

private:
    static constexpr uint64_t STEPS_OF_HALF = SAMPLES_PER_CHIP / (2 * FAST_CLOCKS);
    static_assert(STEPS_OF_HALF * 2 * FAST_CLOCKS == SAMPLES_PER_CHIP, "whole samples in a half period");

    void line_edge(Line* host) {
        if (host != nullptr) {
            double bit = next_line_ / sample_hz_ * BAUD;
            host->takes(bit, top_->o_tx);
            top_->i_rx = host->sends(bit);
        }
        top_->i_line_clk = !top_->i_line_clk;
        top_->eval();
        next_line_ += line_step_;
    }

    std::unique_ptr<VerilatedContext> context_;
    std::unique_ptr<Vsimulated_board> top_;
    uint64_t step_ = 0;
    double next_line_ = 0.5, line_step_, sample_hz_;
};

constexpr int64_t LOCKED_AT = 64 * SAMPLES_PER_CHIP;

} // namespace

#endif
