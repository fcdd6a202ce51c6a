#include "instances/instances.hpp"

namespace jink::inline JINK_LEVEL {
JINK_STEP(, Pack)
JINK_AID(, Pack)
}
