#include "input_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static bool refuse(char why[INPUT_FILE_WHY_CHARS], const char* reason) {
  const int cause = errno;
  snprintf(why, INPUT_FILE_WHY_CHARS, "cannot be read: %.60s", reason);
  errno = cause;
  return false;
}

static bool read_all(int fd, unsigned char* bytes, size_t room, size_t* size) {
  for (*size = 0; *size < room;) {
    const ssize_t got = read(fd, bytes + *size, room - *size);
    if (got == 0) return true;
    if (got < 0 && errno != EINTR) return false;
    if (got > 0) *size += (size_t)got;
  }
  return true;
}

static bool is_readable(int fd, size_t room, char why[INPUT_FILE_WHY_CHARS]) {
  struct stat state;
  errno = 0;
  if (fstat(fd, &state) != 0 || !S_ISREG(state.st_mode)) return refuse(why, "not a plain file");
  if ((unsigned long long)state.st_size <= room) return true;
  snprintf(why, INPUT_FILE_WHY_CHARS, "is %lld bytes long: at most %zu are read",
           (long long)state.st_size, room);
  return false;
}

bool input_file_read(const char* path, void* bytes, size_t room, size_t* size,
                     char why[INPUT_FILE_WHY_CHARS]) {
  const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (fd < 0) return refuse(why, strerror(errno));
  bool good = is_readable(fd, room, why);
  if (good && !read_all(fd, bytes, room, size)) good = refuse(why, strerror(errno));
  close(fd);
  return good;
}

bool input_file_place(const char* path, char place[PATH_MAX]) {
  char leads_to[1];
  if (realpath(path, place) != NULL) return true;
  if (errno != ENOENT) return false;
  const bool is_link = readlink(path, leads_to, sizeof leads_to) >= 0;
  errno = ENOENT;
  if (is_link) return false;
  return snprintf(place, PATH_MAX, "%s", path) < PATH_MAX;
}
