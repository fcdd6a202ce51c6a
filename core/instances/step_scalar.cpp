#include "instances/instances.hpp"

namespace jink::inline JINK_LEVEL {
JINK_STEP(, double)
JINK_AID(, double)
}
