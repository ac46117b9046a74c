#include "hal_linux_output.h"

#include <drm_fourcc.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <xf86drm.h>

// Of the refresh rate: a burst of 5 s may drift by half a millisecond.
static const double kRateTolerance = 1e-4;

static enum lam_status fail(char error[160], const char* what, const char* why) {
  snprintf(error, 160, "%.70s: %.80s", what, why);
  return LAM_HARDWARE;
}

static bool has_name(const drmModeConnector* connector, const char* name) {
  const char* type = drmModeGetConnectorTypeName(connector->connector_type);
  char own[RIG_TEXT_CHARS];
  snprintf(own, sizeof own, "%s-%u", type != NULL ? type : "Unknown", connector->connector_type_id);
  return strcmp(own, name) == 0;
}

static drmModeConnector* find_connector(int fd, const drmModeRes* resources, const char* name,
                                        char error[160]) {
  for (int i = 0; i < resources->count_connectors; i++) {
    drmModeConnector* connector = drmModeGetConnector(fd, resources->connectors[i]);
    if (connector != NULL && has_name(connector, name)) return connector;
    drmModeFreeConnector(connector);
  }
  fail(error, name, "the display device has no such connector (linux.display_connector)");
  return NULL;
}

static double refresh_us(const drmModeModeInfo* mode) {
  return mode->clock > 0 ? mode->htotal * 1e3 * mode->vtotal / mode->clock : INFINITY;
}

// The projector's own pixels: what it prefers, or the first mode where it prefers none.
static const drmModeModeInfo* native_mode(const drmModeConnector* connector) {
  for (int i = 0; i < connector->count_modes; i++) {
    if (connector->modes[i].type & DRM_MODE_TYPE_PREFERRED) return &connector->modes[i];
  }
  return connector->count_modes > 0 ? &connector->modes[0] : NULL;
}

static bool is_better(const drmModeModeInfo* mode, const drmModeModeInfo* best, double wanted_us) {
  if (mode->flags & (DRM_MODE_FLAG_INTERLACE | DRM_MODE_FLAG_DBLSCAN)) return false;
  return best == NULL || fabs(refresh_us(mode) - wanted_us) < fabs(refresh_us(best) - wanted_us);
}

static enum lam_status choose_mode(const drmModeConnector* connector, const struct rig* rig,
                                   struct linux_output* output, char error[160]) {
  const char* name = rig->board.display_connector;
  const drmModeModeInfo *native = native_mode(connector), *best = NULL;
  if (connector->connection != DRM_MODE_CONNECTED || native == NULL) {
    return fail(error, name, "no projector answers: is it switched on?");
  }
  if (native->hdisplay != rig->projector_width_px || native->vdisplay != rig->projector_height_px) {
    snprintf(error, 160, "%.30s has %u x %u pixels, projector.width_px x height_px are %g x %g",
             name, native->hdisplay, native->vdisplay, rig->projector_width_px,
             rig->projector_height_px);
    return LAM_HARDWARE;
  }
  for (int i = 0; i < connector->count_modes; i++) {
    const drmModeModeInfo* mode = &connector->modes[i];
    const bool sized = mode->hdisplay == native->hdisplay && mode->vdisplay == native->vdisplay;
    if (sized && is_better(mode, best, rig_refresh_us(rig))) best = mode;
  }
  if (best == NULL) return fail(error, name, "only interlaced modes have the projector's pixels");
  output->mode = *best;
  output->refresh_us = refresh_us(best);
  if (fabs(output->refresh_us / rig_refresh_us(rig) - 1) <= kRateTolerance) return LAM_OK;
  snprintf(error, 160, "%.30s refreshes at %.4f Hz, projector.refresh_hz is %.10g", name,
           1e6 / output->refresh_us, rig->projector_refresh_hz);
  return LAM_HARDWARE;
}

// The CRTC that feeds the connector now, or the first that can.
static bool find_crtc(int fd, const drmModeRes* resources, const drmModeConnector* connector,
                      struct linux_output* output) {
  output->crtc = 0;
  for (int e = 0; e < connector->count_encoders; e++) {
    drmModeEncoder* encoder = drmModeGetEncoder(fd, connector->encoders[e]);
    if (encoder == NULL) continue;
    for (int i = 0; i < resources->count_crtcs; i++) {
      const bool possible = encoder->possible_crtcs >> i & 1;
      const bool feeds =
          connector->encoder_id == encoder->encoder_id && encoder->crtc_id == resources->crtcs[i];
      if (!possible || (output->crtc != 0 && !feeds)) continue;
      output->crtc = resources->crtcs[i];
      output->pipe = (unsigned)i;
    }
    drmModeFreeEncoder(encoder);
  }
  return output->crtc != 0;
}

struct property {
  uint32_t id;
  uint64_t value, named;  // named: the number of the enumeration's word that is asked for
  bool is_blob;
};
enum found { kFound, kAbsent, kUnknown };  // kUnknown: the kernel did not say; see errno

static void read_property(const drmModePropertyRes* found, const char* word,
                          struct property* property) {
  property->id = found->prop_id;
  property->is_blob = found->flags & DRM_MODE_PROP_BLOB;
  property->named = UINT64_MAX;
  for (int i = 0; word != NULL && i < found->count_enums; i++) {
    if (strcmp(found->enums[i].name, word) == 0) property->named = found->enums[i].value;
  }
}

static enum found find_property(int fd, uint32_t object, const char* const name_and_word[2],
                                struct property* property) {
  drmModeObjectProperties* all = drmModeObjectGetProperties(fd, object, DRM_MODE_OBJECT_ANY);
  if (all == NULL) return kUnknown;
  enum found found = kAbsent;
  for (uint32_t i = 0; found == kAbsent && i < all->count_props; i++) {
    drmModePropertyRes* one = drmModeGetProperty(fd, all->props[i]);
    if (one == NULL) {
      found = kUnknown;
    } else if (strcmp(one->name, name_and_word[0]) == 0) {
      found = kFound;
      read_property(one, name_and_word[1], property);
      property->value = all->prop_values[i];
    }
    drmModeFreeProperty(one);
  }
  drmModeFreeObjectProperties(all);
  return found;
}

static bool is_primary(int fd, uint32_t plane) {
  struct property type;
  return find_property(fd, plane, (const char*[]){"type", NULL}, &type) == kFound &&
         type.value == DRM_PLANE_TYPE_PRIMARY;
}

static bool shows_xrgb(const drmModePlane* plane) {
  for (uint32_t i = 0; i < plane->count_formats; i++) {
    if (plane->formats[i] == DRM_FORMAT_XRGB8888) return true;
  }
  return false;
}

static bool find_plane(int fd, struct linux_output* output) {
  drmModePlaneRes* planes = drmModeGetPlaneResources(fd);
  output->plane = 0;
  for (uint32_t i = 0; planes != NULL && output->plane == 0 && i < planes->count_planes; i++) {
    drmModePlane* plane = drmModeGetPlane(fd, planes->planes[i]);
    if (plane == NULL) continue;
    const bool possible = plane->possible_crtcs >> output->pipe & 1;
    if (possible && shows_xrgb(plane) && is_primary(fd, plane->plane_id)) {
      output->plane = plane->plane_id;
    }
    drmModeFreePlane(plane);
  }
  drmModeFreePlaneResources(planes);
  return output->plane != 0;
}

enum lam_status linux_output_find(int fd, const struct rig* rig, struct linux_output* output,
                                  char error[160]) {
  const char* name = rig->board.display_connector;
  drmModeRes* resources = drmModeGetResources(fd);
  if (resources == NULL) return fail(error, rig->board.display_device, strerror(errno));
  drmModeConnector* connector = find_connector(fd, resources, name, error);
  enum lam_status status = connector != NULL ? LAM_OK : LAM_HARDWARE;
  if (status == LAM_OK) status = choose_mode(connector, rig, output, error);
  if (status == LAM_OK) {
    output->connector = connector->connector_id;
    if (!find_crtc(fd, resources, connector, output)) {
      status = fail(error, name, "no CRTC can feed this connector");
    } else if (!find_plane(fd, output)) {
      status = fail(error, name, "no primary plane shows XRGB8888 on its CRTC");
    }
  }
  drmModeFreeConnector(connector);
  drmModeFreeResources(resources);
  return status;
}

// One property to set. Optional ones are skipped where the object has none; `word` picks a word of
// an enumeration, `value` a number otherwise.
struct wish {
  uint32_t object;
  const char* name;
  uint64_t value;
  bool optional;
  const char* word;
};

// A blob dies with the state that it is in: a copy is kept to go back to.
static bool keep_blob(int fd, struct linux_setting* setting) {
  drmModePropertyBlobRes* blob = drmModeGetPropertyBlob(fd, (uint32_t)setting->before);
  if (blob == NULL) return false;
  const int failed = drmModeCreatePropertyBlob(fd, blob->data, blob->length, &setting->before_blob);
  drmModeFreePropertyBlob(blob);
  setting->before = setting->before_blob;
  return failed == 0;
}

static enum lam_status grant(int fd, const struct wish* wish, struct linux_settings* settings,
                             char error[160]) {
  struct property property;
  const enum found found =
      find_property(fd, wish->object, (const char*[]){wish->name, wish->word}, &property);
  if (found == kUnknown) return fail(error, wish->name, strerror(errno));
  if (found == kAbsent && wish->optional) return LAM_OK;
  if (found == kAbsent) return fail(error, wish->name, "the display has no such property");
  if (wish->word != NULL && property.named == UINT64_MAX) return LAM_OK;
  if (settings->count == LINUX_MOST_SETTINGS) return fail(error, wish->name, "too many planes");
  struct linux_setting* setting = &settings->list[settings->count++];
  *setting = (struct linux_setting){.object = wish->object,
                                    .property = property.id,
                                    .now = wish->word != NULL ? property.named : wish->value,
                                    .before = property.value};
  if (!property.is_blob || setting->before == 0 || keep_blob(fd, setting)) return LAM_OK;
  setting->before = 0;
  return fail(error, wish->name, strerror(errno));
}

// Whatever else the CRTC shows would lie over the patterns.
static enum lam_status clear_other_planes(int fd, const struct linux_output* output,
                                          struct linux_settings* settings, char error[160]) {
  drmModePlaneRes* planes = drmModeGetPlaneResources(fd);
  if (planes == NULL) return fail(error, "the display's planes", strerror(errno));
  enum lam_status status = LAM_OK;
  for (uint32_t i = 0; status == LAM_OK && i < planes->count_planes; i++) {
    drmModePlane* plane = drmModeGetPlane(fd, planes->planes[i]);
    if (plane == NULL) {
      status = fail(error, "a plane of the display", strerror(errno));
      break;
    }
    const uint32_t id = plane->plane_id;
    if (id != output->plane && plane->crtc_id == output->crtc) {
      status = grant(fd, &(struct wish){.object = id, .name = "FB_ID"}, settings, error);
      if (status == LAM_OK) {
        status = grant(fd, &(struct wish){.object = id, .name = "CRTC_ID"}, settings, error);
      }
    }
    drmModeFreePlane(plane);
  }
  drmModeFreePlaneResources(planes);
  return status;
}

enum lam_status linux_output_settings(int fd, const struct linux_output* output,
                                      const uint32_t mode_blob_and_fb[2],
                                      struct linux_settings* settings, char error[160]) {
  const uint64_t width = output->mode.hdisplay, height = output->mode.vdisplay;
  const uint32_t crtc = output->crtc, plane = output->plane, connector = output->connector;
  const struct wish wishes[] = {
      {connector, "CRTC_ID", crtc, false, NULL},
      // More bits make some drivers send less colour (YUV 4:2:2).
      {connector, "max bpc", 8, true, NULL},
      {connector, "Broadcast RGB", 0, true, "Full"},
      {crtc, "MODE_ID", mode_blob_and_fb[0], false, NULL},
      {crtc, "ACTIVE", 1, false, NULL},
      {crtc, "GAMMA_LUT", 0, true, NULL},
      {crtc, "DEGAMMA_LUT", 0, true, NULL},
      {crtc, "CTM", 0, true, NULL},
      {plane, "FB_ID", mode_blob_and_fb[1], false, NULL},
      {plane, "CRTC_ID", crtc, false, NULL},
      {plane, "SRC_X", 0, false, NULL},
      {plane, "SRC_Y", 0, false, NULL},
      {plane, "SRC_W", width << 16, false, NULL},
      {plane, "SRC_H", height << 16, false, NULL},
      {plane, "CRTC_X", 0, false, NULL},
      {plane, "CRTC_Y", 0, false, NULL},
      {plane, "CRTC_W", width, false, NULL},
      {plane, "CRTC_H", height, false, NULL},
      {plane, "rotation", DRM_MODE_ROTATE_0, true, NULL},
  };
  settings->count = 0;
  for (size_t i = 0; i < sizeof wishes / sizeof wishes[0]; i++) {
    const enum lam_status status = grant(fd, &wishes[i], settings, error);
    if (status != LAM_OK) return status;
  }
  return clear_other_planes(fd, output, settings, error);
}

int linux_settings_commit(int fd, const struct linux_settings* settings, bool back) {
  drmModeAtomicReq* request = drmModeAtomicAlloc();
  if (request == NULL) return ENOMEM;
  int failed = 0;
  for (size_t i = 0; failed == 0 && i < settings->count; i++) {
    const struct linux_setting* one = &settings->list[i];
    const int added = drmModeAtomicAddProperty(request, one->object, one->property,
                                               back ? one->before : one->now);
    if (added < 0) failed = -added;
  }
  if (failed == 0) {
    failed = -drmModeAtomicCommit(fd, request, DRM_MODE_ATOMIC_ALLOW_MODESET, NULL);
  }
  drmModeAtomicFree(request);
  return failed;
}

void linux_settings_forget(int fd, struct linux_settings* settings) {
  for (size_t i = 0; i < settings->count; i++) {
    if (settings->list[i].before_blob != 0) {
      drmModeDestroyPropertyBlob(fd, settings->list[i].before_blob);
    }
  }
  settings->count = 0;
}
