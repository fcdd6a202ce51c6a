#include "instances/update_kernels.hpp"

namespace jink::inline JINK_LEVEL {
template UpdateKernels<double> update_kernels<double>(const StateShape &);
}
