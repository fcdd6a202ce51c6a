#include "instances/smooth_tables.hpp"

namespace jink::inline JINK_LEVEL {
template SmoothKernels<Pack> smooth_kernels<Pack>(const StateShape &, bool);
}
