#include "instances/smooth_tables.hpp"

namespace jink::inline JINK_LEVEL {
template SmoothKernels<double> smooth_kernels<double>(const StateShape &, bool);
}
