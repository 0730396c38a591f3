// Address space for OpenBLAS's buffers. OpenBLAS maps a buffer for every calling thread and retries
// endlessly if the system refuses: under a limit of address space (ulimit -v) the program would
// hang. So the space is checked first, and the buffers are allocated while it is available.
#pragma once

namespace tremolo {

// Checks the space that OpenBLAS maps while it is loaded; must be called before the libraries'
// constructors, with the environment of main(). Without enough space it prints a remedy and ends
// the process with exit code 1.
void require_room_for_blas(char** environment);

// Allocates buffers for `threads` concurrent callers of BLAS, the threads of a factorisation and
// this thread's stack; all are kept. Throws Failure (kSystem), with a remedy, if there is not
// enough space.
void take_room_for_blas(unsigned threads);

}  // namespace tremolo
