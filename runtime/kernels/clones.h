// Where the runtime's files find TREMOLO_CLONES.
#pragma once

#include "common/clones.h"
