/* CMake wants a source of every library; all of this one comes from the static ones. */
typedef int tremolo_shared_has_no_code_of_its_own;
