// toml++ itself, so that libtremolo.so needs no other library: Debian's headers are those of a
// shared one.
#define TOML_IMPLEMENTATION
#include <toml++/toml.h>
