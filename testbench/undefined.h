// What Verilog leaves undefined: registers before a reset, and every x of an expression.
//
// Verilator takes a pseudo-random bit for each. In the opposite process each is the other
// one: what is the same in both does not rest on any single one of them.
//
// The compiler includes this before all that Verilator has written. Verilator 5.034 and later
// call the functions with a scope.

#include "verilated.h"

// Set before the model is made.
extern bool goldtof_is_opposite;

template <typename T> inline T goldtof_undefined(T bits, T mask) {
    return goldtof_is_opposite ? ~bits & mask : bits;
}

inline WDataOutP goldtof_undefined_words(int bits, WDataOutP words) {
    if (goldtof_is_opposite) {
        const int last = VL_WORDS_I(bits) - 1;
        for (int word = 0; word <= last; ++word) words[word] = ~words[word];
        words[last] &= VL_MASK_E(bits);
    }
    return words;
}

#define VL_RAND_RESET_I(bits) goldtof_undefined<IData>(VL_RAND_RESET_I(bits), VL_MASK_I(bits))
#define VL_RAND_RESET_Q(bits) goldtof_undefined<QData>(VL_RAND_RESET_Q(bits), VL_MASK_Q(bits))
#define VL_RAND_RESET_W(bits, words) goldtof_undefined_words(bits, VL_RAND_RESET_W(bits, words))

#define VL_SCOPED_RAND_RESET_I(bits, ...) \
    goldtof_undefined<IData>(VL_SCOPED_RAND_RESET_I(bits, __VA_ARGS__), VL_MASK_I(bits))
#define VL_SCOPED_RAND_RESET_Q(bits, ...) \
    goldtof_undefined<QData>(VL_SCOPED_RAND_RESET_Q(bits, __VA_ARGS__), VL_MASK_Q(bits))
#define VL_SCOPED_RAND_RESET_W(bits, words, ...) \
    goldtof_undefined_words(bits, VL_SCOPED_RAND_RESET_W(bits, words, __VA_ARGS__))
#define VL_SCOPED_RAND_RESET_ASSIGN_I(bits, ...) \
    goldtof_undefined<IData>(VL_SCOPED_RAND_RESET_ASSIGN_I(bits, __VA_ARGS__), VL_MASK_I(bits))
#define VL_SCOPED_RAND_RESET_ASSIGN_Q(bits, ...) \
    goldtof_undefined<QData>(VL_SCOPED_RAND_RESET_ASSIGN_Q(bits, __VA_ARGS__), VL_MASK_Q(bits))
#define VL_SCOPED_RAND_RESET_ASSIGN_W(bits, words, ...) \
    goldtof_undefined_words(bits, VL_SCOPED_RAND_RESET_ASSIGN_W(bits, words, __VA_ARGS__))
