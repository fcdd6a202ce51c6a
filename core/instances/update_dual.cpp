#define JINK_UNROLL _Pragma("GCC unroll 1")
#include "run/gradient.hpp"
#include "instances/update_kernels.hpp"

namespace jink::inline JINK_LEVEL {
template UpdateKernels<Slopes> update_kernels<Slopes>(const StateShape &);
}
