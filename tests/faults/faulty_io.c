/* Preloaded (LD_PRELOAD) into a program: calls that write below a folder fail when told to.
 *
 *     TREMOLO_FAULT_AT=/folder/   what stands below; other files are left alone
 *     TREMOLO_FAULT=write-short:N   from the Nth write on, only a part is written
 *                   write-eintr:N   the Nth and the next two writes are interrupted
 *                   write-full:N    from the Nth write on, the disk is full
 *                   open-full:N     from the Nth file on, none can be created
 *                   fsync-eintr:N, fsync-fail:N, rename-fail:N, close-fail:N
 *                   write-kill:N, fsync-kill:N, rename-kill:N   SIGKILL in that call
 *                   open-term:N, write-term:N   SIGTERM in that call; the file is created
 *
 * N counts from 1. If the fault came, TREMOLO_FAULT_MARK names a file that is created. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static int calls[5];
enum { kOpen, kWrite, kFsync, kRename, kClose };

static int below(const char* path) {
  const char* folder = getenv("TREMOLO_FAULT_AT");
  return folder != NULL && strncmp(path, folder, strlen(folder)) == 0;
}

static int descriptor_below(int descriptor) {
  char link[64], path[4096];
  ssize_t length;
  int saved = errno;
  snprintf(link, sizeof(link), "/proc/self/fd/%d", descriptor);
  length = readlink(link, path, sizeof(path) - 1);
  errno = saved;
  if (length < 0) return 0;
  path[length] = '\0';
  return below(path);
}

/* Whether this call, one more of its sort, is to fail so; `times` 0: all from the Nth on. */
static int fails(int sort, const char* fault, int times) {
  const char* asked = getenv("TREMOLO_FAULT");
  const char* mark = getenv("TREMOLO_FAULT_MARK");
  size_t length = strlen(fault);
  int first, number = calls[sort];
  if (asked == NULL || strncmp(asked, fault, length) != 0 || asked[length] != ':') return 0;
  first = atoi(asked + length + 1);
  if (number < first || (times != 0 && number >= first + times)) return 0;
  if (mark != NULL) {
    int file = (int)syscall(SYS_openat, AT_FDCWD, mark, O_CREAT | O_WRONLY | O_CLOEXEC, 0666);
    if (file >= 0) syscall(SYS_close, file);
  }
  return 1;
}

static int open_file(const char* path, int flags, mode_t mode) {
  char whole[8192];
  const char* shown = path;
  if ((flags & O_CREAT) != 0 && path[0] != '/' && getcwd(whole, 4096) != NULL) {
    size_t length = strlen(whole);
    snprintf(whole + length, sizeof(whole) - length, "/%s", path);
    shown = whole;
  }
  if ((flags & O_CREAT) != 0 && below(shown)) {
    ++calls[kOpen];
    if (fails(kOpen, "open-full", 0)) {
      errno = ENOSPC;
      return -1;
    }
  }
  const int descriptor = (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
  if ((flags & O_CREAT) != 0 && below(shown) && fails(kOpen, "open-term", 1))
    kill(getpid(), SIGTERM);
  return descriptor;
}

int open(const char* path, int flags, ...) {
  va_list list;
  mode_t mode;
  va_start(list, flags);
  mode = (mode_t)va_arg(list, int);
  va_end(list);
  return open_file(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list list;
  mode_t mode;
  va_start(list, flags);
  mode = (mode_t)va_arg(list, int);
  va_end(list);
  return open_file(path, flags | O_LARGEFILE, mode);
}

/* How many of the bytes are to be written; -1: none, errno tells why. */
static ssize_t size_to_write(int descriptor, size_t size) {
  if (descriptor <= 2 || !descriptor_below(descriptor)) return (ssize_t)size;
  ++calls[kWrite];
  if (fails(kWrite, "write-kill", 0)) kill(getpid(), SIGKILL);
  if (fails(kWrite, "write-term", 1)) kill(getpid(), SIGTERM);
  if (fails(kWrite, "write-eintr", 3)) {
    errno = EINTR;
    return -1;
  }
  if (fails(kWrite, "write-full", 0)) {
    errno = ENOSPC;
    return -1;
  }
  return (ssize_t)(fails(kWrite, "write-short", 0) ? size / 3 + 1 : size);
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
  const ssize_t part = size_to_write(descriptor, size);
  return part < 0 ? -1 : syscall(SYS_write, descriptor, bytes, (size_t)part);
}

ssize_t pwrite(int descriptor, const void* bytes, size_t size, off_t offset) {
  const ssize_t part = size_to_write(descriptor, size);
  return part < 0 ? -1 : syscall(SYS_pwrite64, descriptor, bytes, (size_t)part, offset);
}

ssize_t pwrite64(int descriptor, const void* bytes, size_t size, off_t offset) {
  return pwrite(descriptor, bytes, size, offset);
}

int fsync(int descriptor) {
  if (descriptor_below(descriptor)) {
    ++calls[kFsync];
    if (fails(kFsync, "fsync-kill", 0)) kill(getpid(), SIGKILL);
    if (fails(kFsync, "fsync-eintr", 3)) {
      errno = EINTR;
      return -1;
    }
    if (fails(kFsync, "fsync-fail", 0)) {
      errno = EIO;
      return -1;
    }
  }
  return (int)syscall(SYS_fsync, descriptor);
}

int rename(const char* from, const char* to) {
  if (below(to)) {
    ++calls[kRename];
    if (fails(kRename, "rename-kill", 0)) kill(getpid(), SIGKILL);
    if (fails(kRename, "rename-fail", 0)) {
      errno = EACCES;
      return -1;
    }
  }
  return (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0u);
}

int close(int descriptor) {
  int broken = 0;
  if (descriptor > 2 && descriptor_below(descriptor)) {
    ++calls[kClose];
    broken = fails(kClose, "close-fail", 0);
  }
  if (syscall(SYS_close, descriptor) != 0) return -1;
  if (broken) errno = EIO;
  return broken ? -1 : 0;
}
