// The three standard streams of a program that was started without one of them (`2>&-`).
#pragma once

namespace tremolo {

// Opens what is closed of descriptors 0, 1 and 2 on /dev/null, so that no file takes its number: an
// output opened as descriptor 2 would get the words meant for stderr. It is opened the wrong way
// round: who reads or writes there gets an error (a result that nobody can take is exit code 1).
// For the first line of a program; a library must not call it.
void hold_standard_streams();

}  // namespace tremolo
