// The whole board in simulation: photons at its pins, its UART at a pseudo-terminal.
//
//   simulated_board [--photons FILE] [--link PATH] [--chips N] [--lose N] [--hosts N]
//
//   --photons FILE  pulses at the detectors, as `goldtof pulses` writes them (default: none; - is
//                   standard input). After the last one the detectors are dark.
//   --link PATH     a name for the pseudo-terminal (default: its own name alone, which is printed)
//   --chips N       end after N chips (default: when the host has gone)
//   --lose N        lose every Nth byte that the board sends (default: none)
//   --hosts N       wait for so many hosts, one after another (default: 1): one that hangs up, and opens
//                   the line anew, is another

#include <deque>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "simulated_board.h"

namespace {

// The host's side of the line: bits of its own length, bytes from and to a pseudo-terminal.
class Host : public Line {
public:
    Host(const char* link, uint64_t lose) : lose_(lose) {
        terminal_ = posix_openpt(O_RDWR | O_NOCTTY);
        if (terminal_ < 0 || grantpt(terminal_) != 0 || unlockpt(terminal_) != 0)
            fail("no pseudo-terminal is to be had");
        const char* name = ptsname(terminal_);
        struct termios raw;
        // The settings stay with the terminal, whoever opens it.
        int other = open(name, O_RDWR | O_NOCTTY);
        if (other < 0 || tcgetattr(other, &raw) != 0) fail("the pseudo-terminal cannot be set up");
        cfmakeraw(&raw);
        tcsetattr(other, TCSANOW, &raw);
        close(other);
        if (link != nullptr) {
            unlink(link);
            if (symlink(name, link) != 0) fail(std::string("cannot make ") + link);
        }
        std::printf("%s\n", link != nullptr ? link : name);
        std::fflush(stdout);
    }

    // Waits until somebody opens the terminal.
    void wait() {
        struct pollfd poll_for = {terminal_, 0, 0};
        while (poll(&poll_for, 1, 0) == 1 && (poll_for.revents & POLLHUP) != 0) usleep(1000);
        fcntl(terminal_, F_SETFL, O_NONBLOCK);
    }

    // Nobody is there: what is on its way to the host is lost.
    void hang_up() {
        to_host_.clear();
        to_board_.clear();
    }

    // Whether the host is still there.
    bool exchange() {
        uint8_t bytes[4096];
        ssize_t count = read(terminal_, bytes, sizeof bytes);
        if (count > 0) to_board_.insert(to_board_.end(), bytes, bytes + count);
        bool is_there = count > 0 || (count < 0 && errno == EAGAIN);
        while (is_there && !to_host_.empty()) {
            ssize_t written = write(terminal_, to_host_.data(), to_host_.size());
            if (written > 0) {
                to_host_.erase(to_host_.begin(), to_host_.begin() + written);
            } else if (errno == EAGAIN) {
                // A host that reads slowly: simulated time waits for it.
                struct pollfd poll_for = {terminal_, POLLOUT, 0};
                poll(&poll_for, 1, 100);
                is_there = (poll_for.revents & POLLHUP) == 0;
            } else {
                is_there = false;
            }
        }
        return is_there;
    }

    // The line to the board at a moment, in bits of the host.
    bool sends(double bit) override {
        if (bit >= sending_until_) {
            if (to_board_.empty()) return true;
            frame_ = 0x200u | uint32_t(to_board_.front()) << 1; // start, eight bits, stop
            to_board_.pop_front();
            sending_from_ = bit;
            sending_until_ = bit + 10;
        }
        return (frame_ >> int(bit - sending_from_)) & 1;
    }

    // Takes the level of the line from the board, which has stood up to this moment.
    void takes(double bit, bool level) override {
        if (!receiving_ && !level) {
            receiving_ = true;
            sample_at_ = bit + 1.5; // the middle of the first bit
            bits_ = 0;
            received_ = 0;
        }
        while (receiving_ && bit >= sample_at_) {
            if (bits_ < 8) {
                received_ |= uint8_t(level) << bits_++;
                sample_at_ += 1;
            } else {
                receiving_ = false;
                // A stop bit that is low is not a byte.
                if (level && (lose_ == 0 || ++count_ % lose_ != 0)) to_host_.push_back(received_);
            }
        }
    }

private:
    int terminal_;
    uint64_t lose_;
    uint64_t count_ = 0;
    std::deque<uint8_t> to_board_;
    std::vector<uint8_t> to_host_;
    uint32_t frame_ = 0;
    double sending_from_ = 0, sending_until_ = 0;
    bool receiving_ = false;
    double sample_at_ = 0;
    int bits_ = 0;
    uint8_t received_ = 0;
};

// The sample at the pins that becomes the first one of the core's first scan: found with a level that
// rises once, in another model of the same board.
int64_t first_sample() {
    Board board;
    const int64_t rises_at = LOCKED_AT + 256 * SAMPLES_PER_CHIP;
    const uint64_t all = SAMPLES_PER_CHIP == 64 ? ~0ull : (1ull << SAMPLES_PER_CHIP) - 1;
    int64_t words = -1; // taken by the core since its reset ended
    bool was_clock = false, was_reset = true;
    for (int64_t step = 0; step < rises_at + 256 * SAMPLES_PER_CHIP; ++step) {
        board.lock(step >= LOCKED_AT);
        bool is_high = step >= rises_at;
        board.step(is_high == !REST ? ~0u : 0u, nullptr);
        bool rose = board.top().o_clk && !was_clock;
        was_clock = board.top().o_clk;
        if (!rose) continue;
        // The word that shows behind an edge without reset is the next chip's.
        if (!was_reset) ++words;
        was_reset = board.top().o_rst;
        uint64_t word = (REST ? ~board.top().o_samples : board.top().o_samples) & all;
        if (words < 0 || word == 0) continue;
        return rises_at - (words * SAMPLES_PER_CHIP + __builtin_ctzll(word));
    }
    fail("a level at the pins never reaches the core");
}

} // namespace

int main(int argc, char** argv) {
    const char *photons_path = nullptr, *link = nullptr;
    uint64_t chips = 0, lose = 0, hosts = 1;
    for (int i = 1; i < argc; i += 2) {
        std::string option = argv[i];
        if (i + 1 == argc) fail(option + " needs a value");
        if (option == "--photons") photons_path = argv[i + 1];
        else if (option == "--link") link = argv[i + 1];
        else if (option == "--chips") chips = std::strtoull(argv[i + 1], nullptr, 10);
        else if (option == "--hosts") hosts = std::strtoull(argv[i + 1], nullptr, 10);
        else if (option == "--lose") lose = std::strtoull(argv[i + 1], nullptr, 10);
        else fail("there is no option " + option + "; those that there are stand in its first lines");
    }

    const int64_t first = first_sample();
    Photons photons(photons_path);
    Board board;
    std::fprintf(stderr, "chip of %.6f ns, gears %.2f chips late\n",
        1e9 * SAMPLES_PER_CHIP / board.sample_hz(), double(LOCKED_AT - first) / SAMPLES_PER_CHIP);
    Host host(link, lose);
    host.wait();
    // The host is asked as often as its bytes come.
    const int64_t steps_of_exchange = int64_t(board.sample_hz() / BAUD * 10);
    bool is_there = true;
    for (int64_t step = 0; is_there && (chips == 0 || step < int64_t(chips) * SAMPLES_PER_CHIP); ++step) {
        board.lock(step >= LOCKED_AT);
        board.step(photons.levels(step - first), &host);
        if (step % steps_of_exchange == 0) is_there = host.exchange();
        if (!is_there && hosts > 1) {
            --hosts;
            host.hang_up();
            host.wait();
            is_there = true;
        }
    }
    if (is_there) host.exchange();
    std::fprintf(stderr, "%.0f chips\n", board.now() / SAMPLES_PER_CHIP);
    if (link != nullptr) unlink(link);
    return 0;
}
