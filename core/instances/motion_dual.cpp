#define JINK_UNROLL _Pragma("GCC unroll 1")
#include "run/gradient.hpp"
#include "instances/motion_kernels.hpp"

namespace jink::inline JINK_LEVEL {
template MotionKernels<Slopes> motion_kernels<Slopes>(const MotionSpec &, bool);
}
