#include "store_disk.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "crc32c.h"

enum { kWriteBytes = 1 << 20 };  // one step; a photograph takes several

static int watched(struct disk* disk, enum disk_action action, const char* path, const char* to) {
  const struct disk_step step = {.action = action, .path = path, .to = to};
  return disk->before == NULL ? 0 : disk->before(disk->context, &step);
}

static int result(int returned) { return returned == 0 ? 0 : errno; }

static int noted(struct disk* disk, const char* path, int failed) {
  if (failed != 0) snprintf(disk->failed, sizeof disk->failed, "%s", path);
  return failed;
}

const char* disk_explain(int error) {
  if (error == EROFS) return "Read-only file system: mount it read-write (dmesg: why it is not)";
  if (error == EACCES || error == EPERM) {
    return "Permission denied: the user that lamella-rigd runs as must own it";
  }
  if (error == ENOENT) return "no such folder: make one";
  if (error == EIO) return "Input/output error: the disk fails, another is needed";
  if (error == EISDIR || error == ENOTEMPTY) {
    return "Is a directory: lamella-rigd made none there: move it elsewhere";
  }
  return strerror(error);
}

int disk_open(struct disk* disk, const char* folder) {
  disk->root = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (disk->root < 0) return errno;
  if (flock(disk->root, LOCK_EX | LOCK_NB) == 0) return 0;
  const int why = errno;
  disk_close(disk);
  return why;
}

void disk_close(struct disk* disk) {
  if (disk->root >= 0) close(disk->root);
  disk->root = -1;
}

int disk_make_folder(struct disk* disk, const char* path) {
  const int refused = watched(disk, DISK_MAKE_FOLDER, path, NULL);
  return noted(disk, path, refused != 0 ? refused : result(mkdirat(disk->root, path, 0755)));
}

static int write_all(struct disk* disk, int fd, const char* path, const uint8_t* bytes,
                     size_t size) {
  while (size > 0) {
    struct disk_step step = {.action = DISK_WRITE, .path = path, .bytes = bytes};
    step.size = size < kWriteBytes ? size : kWriteBytes;
    const int refused = disk->before == NULL ? 0 : disk->before(disk->context, &step);
    if (refused != 0) return refused;
    const ssize_t written = write(fd, bytes, step.size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes += written;
    size -= (size_t)written;
  }
  return 0;
}

// Once on the disk the bytes need not fill the memory that the next photographs want.
static int sync_file(struct disk* disk, int fd, const char* path) {
  const int refused = watched(disk, DISK_SYNC_FILE, path, NULL);
  if (refused != 0) return refused;
  if (fsync(fd) != 0) return errno;
  posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED);
  return 0;
}

static int write_synced(struct disk* disk, const char* path, const uint8_t* bytes, size_t size) {
  int failed = watched(disk, DISK_CREATE, path, NULL);
  if (failed != 0) return failed;
  const int fd = openat(disk->root, path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return errno;
  failed = write_all(disk, fd, path, bytes, size);
  if (failed == 0) failed = sync_file(disk, fd, path);
  if (close(fd) != 0 && failed == 0) failed = errno;
  return failed;
}

int disk_write_whole(struct disk* disk, const char* path, const uint8_t* bytes, size_t size) {
  char beside[DISK_MAX_PATH + 4];
  snprintf(beside, sizeof beside, "%s.tmp", path);
  const int failed = noted(disk, path, write_synced(disk, beside, bytes, size));
  return failed != 0 ? failed : disk_rename(disk, beside, path);
}

int disk_rename(struct disk* disk, const char* path, const char* to) {
  const int refused = watched(disk, DISK_RENAME, path, to);
  const int failed = refused != 0 ? refused : result(renameat(disk->root, path, disk->root, to));
  return noted(disk, path, failed);
}

static int sync_folder(struct disk* disk, const char* path) {
  const int refused = watched(disk, DISK_SYNC_FOLDER, path, NULL);
  if (refused != 0) return refused;
  const int fd = openat(disk->root, path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return errno;
  const int failed = result(fsync(fd));
  close(fd);
  return failed;
}

int disk_sync_folder(struct disk* disk, const char* path) {
  return noted(disk, path, sync_folder(disk, path));
}

int disk_remove(struct disk* disk, const char* path) {
  const int refused = watched(disk, DISK_REMOVE, path, NULL);
  return noted(disk, path, refused != 0 ? refused : result(unlinkat(disk->root, path, 0)));
}

int disk_remove_folder(struct disk* disk, const char* path) {
  const int refused = watched(disk, DISK_REMOVE_FOLDER, path, NULL);
  const int failed = refused != 0 ? refused : result(unlinkat(disk->root, path, AT_REMOVEDIR));
  return noted(disk, path, failed);
}

bool disk_has(const struct disk* disk, const char* path) {
  struct stat found;
  return fstatat(disk->root, path, &found, AT_SYMLINK_NOFOLLOW) == 0;
}

bool disk_is_folder(const struct disk* disk, const char* path) {
  struct stat found;
  return fstatat(disk->root, path, &found, AT_SYMLINK_NOFOLLOW) == 0 && S_ISDIR(found.st_mode);
}

int64_t disk_size(const struct disk* disk, const char* path) {
  struct stat found;
  const bool is_file =
      fstatat(disk->root, path, &found, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(found.st_mode);
  return is_file ? found.st_size : -1;
}

int disk_open_file(const struct disk* disk, const char* path) {
  return openat(disk->root, path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
}

ssize_t disk_read(const struct disk* disk, const char* path, uint8_t* to, size_t room) {
  const int fd = disk_open_file(disk, path);
  if (fd < 0) return -1;
  size_t count = 0;
  for (ssize_t got = 1; got > 0 && count<room; count += got> 0 ? (size_t)got : 0) {
    got = pread(fd, to + count, room - count, (off_t)count);
    if (got < 0) {
      close(fd);
      return -1;
    }
  }
  close(fd);
  return (ssize_t)count;
}

bool disk_crc32c(const struct disk* disk, const char* path, uint64_t* size, uint32_t* crc32c) {
  uint8_t part[16384];
  const int fd = disk_open_file(disk, path);
  ssize_t got = fd < 0 ? -1 : 1;
  for (*size = 0, *crc32c = 0; got > 0; *size += got > 0 ? (uint64_t)got : 0) {
    got = read(fd, part, sizeof part);
    if (got > 0) *crc32c = crc32c_extend(*crc32c, part, (size_t)got);
  }
  if (fd >= 0) close(fd);
  return got == 0;
}

uint64_t disk_free_bytes(const struct disk* disk) {
  struct statvfs about;
  if (fstatvfs(disk->root, &about) != 0) return 0;
  return (uint64_t)about.f_bavail * about.f_frsize;
}

bool disk_is_read_only(const struct disk* disk) {
  struct statvfs about;
  return fstatvfs(disk->root, &about) == 0 && (about.f_flag & ST_RDONLY) != 0;
}

void disk_list(const struct disk* disk, const char* path,
               bool (*found)(void* context, const char* name), void* context) {
  const int fd = openat(disk->root, path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR* folder = fd < 0 ? NULL : fdopendir(fd);
  if (folder == NULL) {
    if (fd >= 0) close(fd);
    return;
  }
  for (const struct dirent* entry; (entry = readdir(folder)) != NULL;) {
    if (entry->d_name[0] != '.' && !found(context, entry->d_name)) break;
  }
  closedir(folder);
}
