// Loops over the two states of an axis or the four of two axes are unrolled; longer ones would take minutes to compile.
#define JINK_UNROLL _Pragma("GCC unroll 4")
#include "run/gradient.hpp"
#include "instances/motion_kernels.hpp"

namespace jink::inline JINK_LEVEL {
// Those of packs are compiled in motion_pack.cpp, unrolled; compiled here too, these slower ones could be linked.
extern template MotionKernels<Pack> motion_kernels<Pack>(const MotionSpec &, bool);
template MotionKernels<Slopes> motion_kernels<Slopes>(const MotionSpec &, bool);
}
