// Drives a verilated sensor_top in blocks of clocks, as a program of its own.
//
// The Verilog may be anyone's: it may end the process, crash or never come back,
// and must not take its caller with it. So it runs here, and the caller talks to
// it through
//   standard input   a socket: requests come in, answers go out
//   standard output  a file in memory that both sides share: words of a block's
//                    inputs, and room for those of its outputs
// Both are moved away before the model is made; what the Verilog prints goes to
// standard error.
//
// goldtof_ports.h is written beside the verilated model for the ports at hand: it
// names the model and packs its ports, in the caller's order, into 64-bit words.
//
// A clock is: inputs set, rising edge, outputs read, falling edge.

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include "goldtof_ports.h"
#include "verilated.h"

namespace {

// What the caller asks for; goldtof's verilated.rs has the same.
enum What : uint64_t { RUN = 0, RUN_BARE = 1, FINISH = 2 };

struct Request {
    uint64_t what;
    uint64_t clocks;
    uint64_t in;   // first word of the inputs in the shared file
    uint64_t out;  // first word of the outputs
    uint64_t skip;   // first word of the skips
    uint64_t skips;  // number of them
};

// Between two clocks the scan's counters are moved on; the rest is as it was.
struct Skip {
    uint64_t clock;   // of the block, before its rising edge
    uint64_t chips;   // what goes into the counter of chips
    uint64_t groups;  // into that of groups
};

// The answer: OK, or HALTED and the length of the text that follows.
enum Status : uint32_t { OK = 0, HALTED = 1 };

struct Answer {
    uint32_t status;
    uint32_t length;
};

// Registers start with pseudo-random values, so that one that no reset reaches is
// seen as a mismatch. The seed is any fixed number.
constexpr int SEED = 1;

int line = -1;
pid_t caller = 0;

void write_all(const void* data, size_t length) {
    const char* bytes = static_cast<const char*>(data);
    while (length > 0) {
        const ssize_t written = ::write(line, bytes, length);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) ::_exit(0);  // Nobody is there to be told.
        bytes += written;
        length -= static_cast<size_t>(written);
    }
}

void answer(Status status, const std::string& text) {
    const Answer header{status, static_cast<uint32_t>(text.size())};
    write_all(&header, sizeof header);
    write_all(text.data(), text.size());
}

// Ends the process at once: neither final blocks nor destructors of a model that
// stands in the middle of a clock.
[[noreturn]] void halt(const std::string& why) {
    std::fflush(nullptr);
    answer(HALTED, why);
    ::_exit(0);
}

[[noreturn]] void halt_at(const char* what, const char* file, int number, const char* detail) {
    halt(std::string(what) + " at " + (file && *file ? file : "?") + ":" + std::to_string(number)
         + (detail && *detail ? std::string(": ") + detail : std::string()));
}

// The caller closes the line or is gone: nothing is left to do.
bool next(Request& request) {
    char* bytes = reinterpret_cast<char*>(&request);
    size_t length = sizeof request;
    while (length > 0) {
        const ssize_t got = ::read(line, bytes, length);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        bytes += got;
        length -= static_cast<size_t>(got);
    }
    return true;
}

// A model in an endless loop does not see that the line is closed.
void end_without_caller(int) {
    if (::getppid() != caller) ::_exit(0);
}

void watch_caller() {
    struct sigaction action = {};
    action.sa_handler = end_without_caller;
    action.sa_flags = SA_RESTART;
    ::sigaction(SIGALRM, &action, nullptr);
    const itimerval every_second = {{1, 0}, {1, 0}};
    ::setitimer(ITIMER_REAL, &every_second, nullptr);
}

int move_away(int from, int replacement) {
    const int to = ::fcntl(from, F_DUPFD_CLOEXEC, 10);
    if (to < 0 || ::dup2(replacement, from) < 0) ::_exit(1);
    return to;
}

uint64_t* share(int file) {
    struct stat found = {};
    if (::fstat(file, &found) != 0) ::_exit(1);
    void* words = ::mmap(nullptr, static_cast<size_t>(found.st_size), PROT_READ | PROT_WRITE,
                         MAP_SHARED, file, 0);
    if (words == MAP_FAILED) ::_exit(1);
    ::close(file);
    return static_cast<uint64_t*>(words);
}

void run(GOLDTOF_MODEL* top, const uint64_t* in, uint64_t* out, uint64_t clocks) {
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
}

void run_block(GOLDTOF_MODEL* top, uint64_t* words, const Request& request) {
    const uint64_t* in = words + request.in;
    uint64_t* out = words + request.out;
    const Skip* skips = reinterpret_cast<const Skip*>(words + request.skip);
    uint64_t done = 0;
    for (uint64_t number = 0; number <= request.skips; ++number) {
        const bool is_last = number == request.skips;
        const uint64_t end = is_last ? request.clocks : skips[number].clock;
        run(top, in + done * GOLDTOF_IN_WORDS, out + done * GOLDTOF_OUT_WORDS, end - done);
        if (!is_last) goldtof_skip(top, skips[number].chips, skips[number].groups);
        done = end;
    }
}

// The same model and clocks with constant inputs and nothing read: the yardstick
// against which co-simulation speed is measured.
void run_bare(GOLDTOF_MODEL* top, const uint64_t* in, uint64_t clocks) {
    goldtof_apply(top, in);
    for (uint64_t clock = 0; clock < clocks; ++clock) {
        top->GOLDTOF_CLOCK = 1;
        top->eval();
        top->GOLDTOF_CLOCK = 0;
        top->eval();
    }
}

void serve(uint64_t* words) {
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
        switch (request.what) {
        case RUN: run_block(top, words, request); break;
        case RUN_BARE: run_bare(top, words + request.in, request.clocks); break;
        case FINISH: top->final(); break;
        default: ::_exit(1);
        }
        std::fflush(nullptr);
        answer(OK, "");
    }
}

}  // namespace

void vl_finish(const char* file, int number, const char* /*hierarchy*/) {
    halt_at("$finish", file, number, nullptr);
}
void vl_stop(const char* file, int number, const char* /*hierarchy*/) {
    halt_at("$stop", file, number, nullptr);
}
void vl_fatal(const char* file, int number, const char* /*hierarchy*/, const char* message) {
    halt_at("fatal error", file, number, message);
}

int main() {
    caller = ::getppid();
    const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    line = move_away(STDIN_FILENO, nothing);
    uint64_t* words = share(move_away(STDOUT_FILENO, STDERR_FILENO));
    // A process that ends by itself has said all that it meant to say.
    std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
    watch_caller();
    try {
        serve(words);
    } catch (const std::exception& thrown) {
        halt(std::string("a C++ exception: ") + thrown.what());
    } catch (...) {
        halt("a C++ exception");
    }
    std::fflush(nullptr);
    ::_exit(0);
}
