// Room for OpenBLAS's buffers. It maps one for every thread that calls it and, where the system
// refuses, asks again without end: under a limit of address space (ulimit -v) the program would
// spin for ever. So the system is asked first, and the buffers are taken while there is room.
#pragma once

namespace tremolo {

// For what OpenBLAS maps while it is loaded: to be called before the constructors of the libraries,
// with the environment as main() gets it. Without room it says what would do and ends the process
// with exit code 1.
void require_room_for_blas(char** environment);

// Buffers for `threads` threads that call BLAS at once, the threads of a factor and the stack of
// this thread, all kept from here on. Throws Failure (kSystem)
// when there is no room, saying what would do.
void take_room_for_blas(unsigned threads);

}  // namespace tremolo
