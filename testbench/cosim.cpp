// Drives a verilated sensor_top in blocks of clocks.
//
// The caller hands over a block of input words and gets a block of output words
// back, so the language border is crossed once per block and not once per clock.
// goldtof_ports.h is written beside the verilated model for the ports at hand:
// it names the model and packs its ports, in the caller's order, into 64-bit
// words.
//
// A clock is: inputs set, rising edge, outputs read, falling edge.

#include <cstdint>
#include <exception>
#include <new>
#include <string>

#include "goldtof_ports.h"
#include "verilated.h"

namespace {

// $fatal, $stop and $finish in the user's Verilog must not end the caller's
// process: they end the block with an error.
struct Halted : std::exception {
    std::string message;
    explicit Halted(std::string text) : message(std::move(text)) {}
    const char* what() const noexcept override { return message.c_str(); }
};

struct Model {
    VerilatedContext context;
    GOLDTOF_MODEL* top = nullptr;
    std::string error;
    bool halted = false;

    ~Model() {
        // A model that was halted in the middle of a clock is not run again,
        // not even its final blocks.
        if (top && !halted) top->final();
        delete top;
    }
};

[[noreturn]] void halt(const char* what, const char* file, int line, const char* detail) {
    throw Halted(std::string(what) + " at " + (file ? file : "?") + ":" + std::to_string(line)
                 + (detail && *detail ? std::string(": ") + detail : std::string()));
}

}  // namespace

void vl_finish(const char* file, int line, const char* /*hierarchy*/) {
    halt("$finish", file, line, nullptr);
}
void vl_stop(const char* file, int line, const char* /*hierarchy*/) {
    halt("$stop", file, line, nullptr);
}
void vl_fatal(const char* file, int line, const char* /*hierarchy*/, const char* message) {
    halt("fatal error", file, line, message);
}

extern "C" {

// Makes a model. Registers start with pseudo-random values drawn from `seed`,
// so that a register that no reset reaches is seen as a mismatch.
// Returns null when memory is short or the model cannot be made.
void* goldtof_new(int32_t seed) {
    Model* model = nullptr;
    try {
        model = new Model;
        model->context.randReset(2);
        model->context.randSeed(seed);
        model->top = new GOLDTOF_MODEL{&model->context};
        model->top->GOLDTOF_CLOCK = 0;
        model->top->eval();
        return model;
    } catch (const std::exception&) {
        delete model;
        return nullptr;
    }
}

// Runs `clocks` clocks: clock c takes words [c * GOLDTOF_IN_WORDS ..) of `in`
// and gives words [c * GOLDTOF_OUT_WORDS ..) of `out`.
// Returns 0, or 1 when the Verilog ended the simulation (see goldtof_error).
int32_t goldtof_run(void* handle, const uint64_t* in, uint64_t* out, uint64_t clocks) {
    Model* model = static_cast<Model*>(handle);
    GOLDTOF_MODEL* top = model->top;
    try {
        for (uint64_t clock = 0; clock < clocks; ++clock) {
            goldtof_apply(top, in);
            top->GOLDTOF_CLOCK = 1;
            top->eval();
            goldtof_sample(top, out);
            top->GOLDTOF_CLOCK = 0;
            top->eval();
            in += GOLDTOF_IN_WORDS;
            out += GOLDTOF_OUT_WORDS;
        }
        return 0;
    } catch (const std::exception& halted) {
        model->halted = true;
        model->error = halted.what();
        return 1;
    }
}

// The same model and clocks with constant inputs and nothing read: the yardstick
// against which co-simulation speed is measured.
int32_t goldtof_run_bare(void* handle, const uint64_t* in, uint64_t clocks) {
    Model* model = static_cast<Model*>(handle);
    GOLDTOF_MODEL* top = model->top;
    try {
        goldtof_apply(top, in);
        for (uint64_t clock = 0; clock < clocks; ++clock) {
            top->GOLDTOF_CLOCK = 1;
            top->eval();
            top->GOLDTOF_CLOCK = 0;
            top->eval();
        }
        return 0;
    } catch (const std::exception& halted) {
        model->halted = true;
        model->error = halted.what();
        return 1;
    }
}

// Why the last run returned 1; valid until the model is deleted.
const char* goldtof_error(void* handle) { return static_cast<Model*>(handle)->error.c_str(); }

void goldtof_delete(void* handle) {
    try {
        delete static_cast<Model*>(handle);
    } catch (const std::exception&) {
        // A final block that calls $fatal: there is nobody left to tell.
    }
}

}  // extern "C"
