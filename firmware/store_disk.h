// The store's file operations. Each one that changes the disk can be watched, refused or made the
// last one of the process: what a power cut leaves is tested at every one of them. Paths are
// relative to the store's folder. 0, or an errno.
#ifndef LAMELLA_FIRMWARE_STORE_DISK_H
#define LAMELLA_FIRMWARE_STORE_DISK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

enum { DISK_MAX_PATH = 64 };

enum disk_action {
  DISK_MAKE_FOLDER,
  DISK_CREATE,
  DISK_WRITE,  // `bytes` after those that the file has
  DISK_SYNC_FILE,
  DISK_RENAME,
  DISK_SYNC_FOLDER,
  DISK_REMOVE,
  DISK_REMOVE_FOLDER,
  DISK_ACTIONS,
};

struct disk_step {
  enum disk_action action;
  const char *path, *to;
  const uint8_t* bytes;
  size_t size;
};

struct disk {
  int root;                                                    // the folder; -1: none
  int (*before)(void* context, const struct disk_step* step);  // 0: go on; an errno: it fails so
  void* context;
  char failed[DISK_MAX_PATH];  // of the last step that failed; "": none did
};

// What is wrong and, where that is not plain, what to do.
const char* disk_explain(int error);

// Takes the folder, which must be there, for this process alone (EWOULDBLOCK: another has it).
int disk_open(struct disk* disk, const char* folder);
void disk_close(struct disk* disk);

int disk_make_folder(struct disk* disk, const char* path);
// Written beside its place, synced, renamed into it. Only disk_sync_folder() makes the name last.
int disk_write_whole(struct disk* disk, const char* path, const uint8_t* bytes, size_t size);
int disk_rename(struct disk* disk, const char* path, const char* to);
int disk_sync_folder(struct disk* disk, const char* path);  // ".": the store's own
int disk_remove(struct disk* disk, const char* path);
int disk_remove_folder(struct disk* disk, const char* path);

// What can be read never changes the disk, and is not watched.
bool disk_has(const struct disk* disk, const char* path);
bool disk_is_folder(const struct disk* disk, const char* path);
int64_t disk_size(const struct disk* disk, const char* path);   // -1: no such file
int disk_open_file(const struct disk* disk, const char* path);  // a descriptor, or -1
// At most `room` bytes from the start; -1 where it cannot be read.
ssize_t disk_read(const struct disk* disk, const char* path, uint8_t* to, size_t room);
bool disk_crc32c(const struct disk* disk, const char* path, uint64_t* size, uint32_t* crc32c);
uint64_t disk_free_bytes(const struct disk* disk);
bool disk_is_read_only(const struct disk* disk);
// Calls `found` with every name in a folder until it says false.
void disk_list(const struct disk* disk, const char* path,
               bool (*found)(void* context, const char* name), void* context);

#endif
