// This file is empty: the module consists of the library functions that the linker exports.
