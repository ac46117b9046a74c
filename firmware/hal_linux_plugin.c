#include "hal_linux_plugin.h"

#include <dlfcn.h>
#include <stdio.h>

static enum lam_status refuse(struct linux_frames* frames, const char* why) {
  snprintf(frames->error, sizeof frames->error, "libcamera: %s", why);
  return LAM_HARDWARE;
}

enum lam_status linux_plugin_open(struct linux_frames* frames,
                                  const struct linux_frames_wish* wish) {
  void* library = dlopen(LAMELLA_PLUGIN_DIR "/" LINUX_FRAMES_PLUGIN, RTLD_NOW | RTLD_NODELETE);
  if (library == NULL) return refuse(frames, dlerror());
  const struct linux_frames_plugin* plugin = dlsym(library, LINUX_FRAMES_ENTRY);
  if (plugin != NULL && plugin->abi == LINUX_FRAMES_ABI) return plugin->open(frames, wish);
  dlclose(library);
  return refuse(frames, "the plug-in in " LAMELLA_PLUGIN_DIR
                        " is of another version: install that of this lamella-rigd");
}
