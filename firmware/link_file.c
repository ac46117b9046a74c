#include "link_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static enum lam_status fail(enum lam_status status, const char* path, const char* why, char* error,
                            size_t error_size) {
  snprintf(error, error_size, "%s: %s", path, why);
  return status;
}

bool link_file_path(const char* folder, const char* name, char path[LINK_FILE_PATH_CHARS]) {
  const int length = snprintf(path, LINK_FILE_PATH_CHARS, "%s/%s", folder, name);
  return length > 0 && length < LINK_FILE_PATH_CHARS;
}

// What is wrong with a file that is open, or NULL.
static const char* find_fault(int fd, size_t room) {
  struct stat state;
  if (fstat(fd, &state) != 0 || !S_ISREG(state.st_mode)) return "not a plain file";
  if ((state.st_mode & 077) != 0) return "others may read or write it: chmod 600";
  if (state.st_size < 0 || (size_t)state.st_size >= room) return "larger than the rig may read";
  return NULL;
}

static bool read_all(int fd, char* text, size_t room, size_t* size) {
  for (*size = 0; *size < room;) {
    const ssize_t got = read(fd, text + *size, room - *size);
    if (got < 0) return false;
    if (got == 0) return true;
    *size += (size_t)got;
  }
  return false;
}

enum lam_status link_file_read(const char* path, char* text, size_t room, size_t* size, char* error,
                               size_t error_size) {
  const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (fd < 0) {
    const enum lam_status status = errno == ENOENT ? LAM_WRONG_STATE : LAM_BAD_INPUT;
    return fail(status, path, strerror(errno), error, error_size);
  }
  const char* why = find_fault(fd, room);
  if (why == NULL && !read_all(fd, text, room, size)) why = "cannot be read";
  close(fd);
  if (why != NULL) return fail(LAM_BAD_INPUT, path, why, error, error_size);
  text[*size] = '\0';
  return LAM_OK;
}

static bool write_and_sync(int fd, const char* text, size_t size) {
  for (size_t done = 0; done < size;) {
    const ssize_t wrote = write(fd, text + done, size - done);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) return false;
    done += (size_t)wrote;
  }
  return fsync(fd) == 0;
}

// A rename is on the disk once its folder is.
static bool sync_folder_of(const char* path) {
  char folder[LINK_FILE_PATH_CHARS];
  snprintf(folder, sizeof folder, "%s", path);
  char* slash = strrchr(folder, '/');
  if (slash == NULL) return false;
  slash[slash == folder ? 1 : 0] = '\0';
  const int fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool synced = fd >= 0 && fsync(fd) == 0;
  if (fd >= 0) close(fd);
  return synced;
}

enum lam_status link_file_write(const char* path, const char* text, size_t size, char* error,
                                size_t error_size) {
  char beside[LINK_FILE_PATH_CHARS + 8];
  snprintf(beside, sizeof beside, "%s.new", path);
  unlink(beside);  // of a start that was cut short
  const int fd = open(beside, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (fd < 0) return fail(LAM_BAD_INPUT, beside, strerror(errno), error, error_size);
  bool written = write_and_sync(fd, text, size);
  written = close(fd) == 0 && written;
  if (written && rename(beside, path) == 0 && sync_folder_of(path)) return LAM_OK;
  const int cause = errno;
  unlink(beside);
  return fail(LAM_HARDWARE, path, strerror(cause), error, error_size);
}
