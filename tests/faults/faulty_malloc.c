/* Preloaded (LD_PRELOAD) into one of several ranks: large requests for memory fail there.
 *
 *     TREMOLO_FAULT_RANK=R    of Open MPI's numbering
 *     TREMOLO_FAULT_BYTES=N   of one request: this many or more are refused */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

void* __libc_malloc(size_t size);

void* malloc(size_t size) {
  const char* rank = getenv("OMPI_COMM_WORLD_RANK");
  const char* asked = getenv("TREMOLO_FAULT_RANK");
  const char* bytes = getenv("TREMOLO_FAULT_BYTES");
  if (rank != NULL && asked != NULL && bytes != NULL && strcmp(rank, asked) == 0 &&
      size >= strtoull(bytes, NULL, 10)) {
    errno = ENOMEM;
    return NULL;
  }
  return __libc_malloc(size);
}
