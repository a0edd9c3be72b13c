// A testbench in C++ round Verilator's model of a sensor, with goldtof's scoreboard.
//
//     verilator --cc --exe --build -CFLAGS -I$PWD/capi/include --top sensor_top \
//         -y generated/quick generated/quick/sensor_top.v $PWD/capi/examples/testbench.cpp \
//         $PWD/target/release/libgoldtof_c.so
//     LD_LIBRARY_PATH=target/release obj_dir/Vsensor_top scenes/quick.toml

#include <cstdint>
#include <cstdio>
#include <memory>
#include <random>

#include "Vsensor_top.h"
#include "goldtof.h"
#include "verilated.h"

namespace {

constexpr int CLOCKS = 20000;

struct FreeScene {
    void operator()(goldtof_scene *scene) const { goldtof_scene_free(scene); }
};
struct FreeScoreboard {
    void operator()(goldtof_scoreboard *board) const { goldtof_scoreboard_free(board); }
};

// Puts ports one behind the other into words of 64 bits, the first at bit 0.
class Record {
  public:
    void put(std::uint64_t value, int width) {
        word_ |= value << bits_;
        bits_ += width;
    }
    std::uint64_t word() const { return word_; }

  private:
    std::uint64_t word_ = 0;
    int bits_ = 0;
};

int fail() {
    std::fprintf(stderr, "error: %s\n", goldtof_last_error());
    return 2;
}

}  // namespace

int main(int argc, char **argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: testbench SCENE\n");
        return 2;
    }
    const std::unique_ptr<goldtof_scene, FreeScene> scene(goldtof_scene_load(argv[1]));
    if (!scene) return fail();
    const std::unique_ptr<goldtof_scoreboard, FreeScoreboard> board(
        goldtof_scoreboard_new(scene.get(), -1, -1, 0, 4096));
    if (!board) return fail();
    const struct {
        const char *name;
        int width;
    } ports[] = {{"i_rst", 1},          {"i_samples", 8},     {"m_axis_tready", 1},
                 {"o_laser", 1},        {"o_epoch", 1},       {"m_axis_tdata", 16},
                 {"m_axis_tvalid", 1},  {"m_axis_tlast", 1},  {"o_overrun", 1}};
    for (const auto &port : ports)
        if (goldtof_scoreboard_port(board.get(), port.name, port.width) != GOLDTOF_STATUS_OK)
            return fail();
    if (goldtof_scoreboard_begin(board.get()) != 1) return fail();

    Vsensor_top design;
    std::mt19937 random(1);
    for (int clock = 0; clock < CLOCKS; clock++) {
        design.i_rst = clock < 4 || (clock >= 9000 && clock < 9002);
        design.i_samples = random() & random() & random() & 0xff;
        design.m_axis_tready = random() % 4 != 0;
        design.i_clk = 0;
        design.eval();
        design.i_clk = 1;
        design.eval();
        Record record;
        record.put(design.i_rst, 1);
        record.put(design.i_samples, 8);
        record.put(design.m_axis_tready, 1);
        record.put(design.o_laser, 1);
        record.put(design.o_epoch, 1);
        record.put(design.m_axis_tdata, 16);
        record.put(design.m_axis_tvalid, 1);
        record.put(design.m_axis_tlast, 1);
        record.put(design.o_overrun, 1);
        if (goldtof_scoreboard_word(board.get(), record.word()) != GOLDTOF_STATUS_OK) break;
    }
    design.final();
    const goldtof_status verdict = goldtof_scoreboard_verdict(board.get());
    std::printf("%s\n", goldtof_scoreboard_report(board.get()));
    return verdict == GOLDTOF_STATUS_OK ? 0 : 1;
}
