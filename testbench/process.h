// A verilated model as a program of its own: what is the same for every model.
//
// The Verilog may be anyone's: it may end the process, crash or never come back,
// and must not take its caller with it. So it runs here, and the caller talks to
// it through
//   standard input   a socket: requests come in, answers go out
//   standard output  a file in memory that both sides share
// Both are moved away before the model is made; what the Verilog prints goes to
// standard error.
//
// Whoever includes this defines serve(), and the requests that it knows.

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#ifndef GOLDTOF_WITHOUT_VERILATOR
#include "verilated.h"
#endif

// Answers requests until there are no more; `words` is the shared file. Of the processes of a
// model the first is 0, the one that takes the opposite of every bit that Verilog leaves undefined
// is 1, and those behind take others.
static void serve(uint64_t* words, int number);

namespace {

// goldtof's process.rs has the same.
struct Request {
    uint64_t what;
    uint64_t arguments[5];
};

// The answer: OK, or HALTED and the length of the text that follows.
enum Status : uint32_t { OK = 0, HALTED = 1 };

struct Answer {
    uint32_t status;
    uint32_t length;
};

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

int main(int count, char** arguments) {
    caller = ::getppid();
    const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    line = move_away(STDIN_FILENO, nothing);
    uint64_t* words = share(move_away(STDOUT_FILENO, STDERR_FILENO));
    // A process that ends by itself has said all that it meant to say.
    std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
    watch_caller();
    try {
        serve(words, count > 1 ? std::atoi(arguments[1]) : 0);
    } catch (const std::exception& thrown) {
        halt(std::string("a C++ exception: ") + thrown.what());
    } catch (...) {
        halt("a C++ exception");
    }
    std::fflush(nullptr);
    ::_exit(0);
}
