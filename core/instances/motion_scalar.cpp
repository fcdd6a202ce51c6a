#include "instances/motion_kernels.hpp"

namespace jink::inline JINK_LEVEL {
template MotionKernels<double> motion_kernels<double>(const MotionSpec &, bool);
}
