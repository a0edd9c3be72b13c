// goldtof for C, C++ and SystemVerilog (DPI-C): scenes, the reference model clocked in
// batches, and a scoreboard that stands beside a design in a testbench.
//
// A function that can fail gives a null pointer, or a status other than GOLDTOF_OK, and
// then goldtof_last_error() has the reason in words, those of the command line. Nothing
// that goes wrong inside ends the program.
//
// What callers have to keep, everywhere: a handle is one that a function here has made and
// that was not freed; a text ends with a zero byte; an array is as long as said. Null
// pointers are refused, not followed, and freeing one does nothing. Several threads may use
// a handle; each waits for the other.

#ifndef GOLDTOF_H
#define GOLDTOF_H

#include <stddef.h>
#include <stdint.h>

// Made by cbindgen from capi/src; do not edit.

// In place of a result's latency: the design's own, which its first result tells.
#define GOLDTOF_LATENCY_AUTO -2

// How a call ended.
enum goldtof_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // As it should.
  GOLDTOF_STATUS_OK = 0,
  // A port differs from what the reference model expects.
  GOLDTOF_STATUS_MISMATCH = 1,
  // An argument, the scene or an input is wrong.
  GOLDTOF_STATUS_INVALID = 2,
  // Every port was as expected, but too little has happened to tell.
  GOLDTOF_STATUS_INCONCLUSIVE = 3,
  // A mistake in goldtof itself; the handle cannot be used any more.
  GOLDTOF_STATUS_INTERNAL = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum goldtof_status goldtof_status;
#else
typedef int32_t goldtof_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A reference model.
typedef struct goldtof_model goldtof_model;

// A scene.
typedef struct goldtof_scene goldtof_scene;

// A scoreboard.
typedef struct goldtof_scoreboard goldtof_scoreboard;

// An output port, and where its bits lie in a clock's record.
typedef struct goldtof_port {
  // Its name, for as long as the model lives.
  const char *name;
  // Bits.
  uint32_t width;
  // The record's word of its bit 0. A port wider than 64 bits has whole words, the
  // lowest first.
  uint32_t word;
  // The bit in that word.
  uint32_t shift;
} goldtof_port;

// What a host drives at the AXI4-Lite slave of a design with registers, at a clock.
typedef struct goldtof_host {
  // `s_axil_wdata`.
  uint32_t write_data;
  // `s_axil_awaddr`.
  uint16_t write_address;
  // `s_axil_araddr`.
  uint16_t read_address;
  // `s_axil_wstrb`.
  uint8_t write_strobe;
  // `s_axil_awvalid`; this and those below are 0 for low.
  uint8_t write_address_valid;
  // `s_axil_wvalid`.
  uint8_t write_valid;
  // `s_axil_bready`.
  uint8_t write_response_ready;
  // `s_axil_arvalid`.
  uint8_t read_address_valid;
  // `s_axil_rready`.
  uint8_t read_ready;
} goldtof_host;

// A phase step whose integration is over.
typedef struct goldtof_result {
  // The clock after whose rising edge its group comes to the stream, if nothing
  // stands there any more.
  uint64_t clock;
  // Number of the scan since the last reset.
  uint64_t scan;
  // Number of the step within the scan.
  uint64_t step;
  // The signed count, saturated as the hardware does.
  int64_t count;
  // Hits counted, up and down together.
  uint64_t total;
  // Number of the detector.
  uint32_t detector;
} goldtof_result;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// A model of the hardware of a scene's sensor before its first clock; null if there is
// none. Its results come `result_latency_clocks` after a group's last word, and peaks
// `peak_latency_clocks` after a scan's; below 0, as late as those of the emitted design.
struct goldtof_model *goldtof_model_new(const struct goldtof_scene *scene,
                                        int32_t result_latency_clocks,
                                        int32_t peak_latency_clocks);

// Ends a model.
void goldtof_model_free(struct goldtof_model *model);

// Number of detectors; 0 if the handle is bad.
uint32_t goldtof_model_detectors(const struct goldtof_model *model);

// Number of sample words of a clock: one for each detector, or for each of its cells if these have an
// input each; 0 if the handle is bad.
uint32_t goldtof_model_inputs(const struct goldtof_model *model);

// Words of 64 bits of a clock's record of outputs; 0 if the handle is bad.
uint32_t goldtof_model_words(const struct goldtof_model *model);

// Number of output ports; 0 if the handle is bad.
uint32_t goldtof_model_ports(const struct goldtof_model *model);

// Tells of output port number `index`, in the order of the Verilog.
goldtof_status goldtof_model_port(const struct goldtof_model *model,
                                  uint32_t index,
                                  struct goldtof_port *port);

// Clocks the model through a batch; its state stays for the next one. `samples` has
// goldtof_model_inputs() words for each clock, bit 0 the earliest sample. `reset` and `ready`
// have a byte for each clock, 0 for low; null stands for low and for high at all clocks.
// `outputs` gets goldtof_model_words() words for each clock: what the ports show after
// its rising edge. If an input is wrong, nothing has changed.
goldtof_status goldtof_model_clock(struct goldtof_model *model,
                                   size_t clocks,
                                   const uint64_t *samples,
                                   const uint8_t *reset,
                                   const uint8_t *ready,
                                   uint64_t *outputs);

// The same of a design with registers, whose `host` drives something at each clock; null stands for
// zeros at all of them.
goldtof_status goldtof_model_clock_hosted(struct goldtof_model *model,
                                          size_t clocks,
                                          const uint64_t *samples,
                                          const uint8_t *reset,
                                          const uint8_t *ready,
                                          const struct goldtof_host *host,
                                          uint64_t *outputs);

// Takes up to `room` results of the clocks so far, in order, and gives their number;
// with null for `results`, how many there are.
size_t goldtof_model_take_results(struct goldtof_model *model,
                                  struct goldtof_result *results,
                                  size_t room);

// Reads and checks the scene in a file; null if it cannot be used.
struct goldtof_scene *goldtof_scene_load(const char *path);

// Reads and checks a scene's text, TOML as in a file; null if it cannot be used. `name`
// is what errors call the file; without its ending it is the scene's name.
struct goldtof_scene *goldtof_scene_parse(const char *name, const char *toml);

// Overrides a key of the text, as `--set` does: `path.distance=5 m`; or several, each on
// a line. If one cannot be, the scene stays as it is.
goldtof_status goldtof_scene_set(struct goldtof_scene *scene, const char *assignment);

// Ends a scene. Models and scoreboards that were made of it stay.
void goldtof_scene_free(struct goldtof_scene *scene);

// A scoreboard for a design of this scene; null if there can be none. Latencies are as
// with goldtof_model_new(), or GOLDTOF_LATENCY_AUTO of results, which keeps the clocks until the first.
// `batch_clocks` are compared at once: a mismatch is told when
// the last of them has come.
struct goldtof_scoreboard *goldtof_scoreboard_new(const struct goldtof_scene *scene,
                                                  int32_t result_latency_clocks,
                                                  int32_t peak_latency_clocks,
                                                  int32_t is_idle_payload_free,
                                                  int32_t batch_clocks);

// Tells the next port of the testbench's record: its bits stand behind those of the one
// before it, the first at bit 0 of the first word. All ports are told before the first
// clock; an output that this scene's sensor does not have is passed over.
goldtof_status goldtof_scoreboard_port(struct goldtof_scoreboard *scoreboard,
                                       const char *name,
                                       int32_t width);

// Ends the telling of ports, and gives the words of a clock's record; 0 if the ports are
// not the sensor's.
int32_t goldtof_scoreboard_begin(struct goldtof_scoreboard *scoreboard);

// Takes the next word of the present clock's record: the inputs before the clock's
// rising edge, and the outputs after it. GOLDTOF_STATUS_MISMATCH once a port was found
// to differ; goldtof_scoreboard_report() says which, where and how.
goldtof_status goldtof_scoreboard_word(struct goldtof_scoreboard *scoreboard, uint64_t word);

// Takes the next words of records, as goldtof_scoreboard_word() does one by one: of some
// clocks, whole ones or not, in one call.
goldtof_status goldtof_scoreboard_words(struct goldtof_scoreboard *scoreboard,
                                        const uint64_t *words,
                                        int32_t count);

// Compares what has come, and judges: GOLDTOF_STATUS_OK, _MISMATCH, or _INCONCLUSIVE if
// too little has happened to tell.
goldtof_status goldtof_scoreboard_verdict(struct goldtof_scoreboard *scoreboard);

// What was compared and found, in words: verdict, the first mismatch with clock, time,
// port, expected and got, and what was exercised. Valid until the next call of this
// function with this scoreboard, or its end; null if the handle is bad.
const char *goldtof_scoreboard_report(struct goldtof_scoreboard *scoreboard);

// Ends a scoreboard.
void goldtof_scoreboard_free(struct goldtof_scoreboard *scoreboard);

// What the last call of this thread that failed had to say; an empty text if none has.
// It stays valid until the thread's next call that fails.
const char *goldtof_last_error(void);

// The version of goldtof, for as long as the program runs.
const char *goldtof_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* GOLDTOF_H */
