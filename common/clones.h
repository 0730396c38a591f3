// One binary for every x86-64: the loader picks the widest vectors the machine has. Sanitizers
// instrument before the resolver may run, so they get the plain version.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(TREMOLO_SANITIZED)
#define TREMOLO_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define TREMOLO_CLONES
#endif
