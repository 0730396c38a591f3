// Nothing of its own: the module is what the linker takes from the library for its exports.
