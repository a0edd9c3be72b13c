// What Verilog leaves undefined: registers before a reset, and every x of an expression.
//
// Verilator takes a pseudo-random bit for each. In the opposite process each is the other
// one, and in further ones each is another pseudo-random one: what is the same in all of them does
// not rest on any single one of these bits. Verilator's seed is the same in all of them: it is saved
// with what a model holds, which is compared.
//
// The compiler includes this before all that Verilator has written. Verilator 5.034 and later
// call the functions with a scope.

#include "verilated.h"
#include "verilated_save.h"

// The bits of a process that are others than in the first.
extern uint64_t goldtof_flips();
// Set where the model takes an undefined bit.
extern bool goldtof_has_read_x;

template <typename T> inline T goldtof_undefined(T bits, T mask) {
    goldtof_has_read_x = true;
    return (bits ^ static_cast<T>(goldtof_flips())) & mask;
}

inline WDataOutP goldtof_undefined_words(int bits, WDataOutP words) {
    goldtof_has_read_x = true;
    const int last = VL_WORDS_I(bits) - 1;
    for (int word = 0; word <= last; ++word) words[word] ^= static_cast<EData>(goldtof_flips());
    words[last] &= VL_MASK_E(bits);
    return words;
}

// What an expression gives where it is x: the same in one process for ever, and no part of what
// the design holds. goldtof declares Verilator's variables for it as this.
template <typename T> class GoldtofX final {
    T m_value;

public:
    GoldtofX& operator=(T value) {
        m_value = value;
        return *this;
    }
    operator T() const {
        goldtof_has_read_x = true;
        return m_value;
    }
};

template <typename T>
inline VerilatedSerialize& operator<<(VerilatedSerialize& os, const GoldtofX<T>&) {
    return os;
}
template <typename T>
inline VerilatedDeserialize& operator>>(VerilatedDeserialize& os, GoldtofX<T>&) {
    return os;
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
