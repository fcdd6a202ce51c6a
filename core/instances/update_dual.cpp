// As in motion_dual.cpp.
#define JINK_UNROLL _Pragma("GCC unroll 4")
#include "run/gradient.hpp"
#include "instances/update_kernels.hpp"

namespace jink::inline JINK_LEVEL {
template UpdateKernels<Slopes> update_kernels<Slopes>(const StateShape &);
}
