#include "review/sheet.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cfloat>
#include <cstdio>
#include <opencv2/imgproc.hpp>

namespace lamella::review {

namespace {

struct Tile {
  std::string name, note;
  LayerGains gains;
  float exposure;
  bool is_on;
};

// Share of the paper's "+2 f-stops": each layer is shown as bright as it can be seen, and says so.
constexpr float kSpecularGain = 2.f, kSingleGain = 24.f, kShallowGain = 2.f, kDeepGain = 1.f;

std::string times(float gain) {
  char text[16] = "";
  if (gain != 1.f) std::snprintf(text, sizeof(text), "\u00d7%.0f", double(gain));
  return text;
}

// "mean free path 2.00  0.96  0.72 mm": mean over the regions that have one.
template <class LayerOf>
std::string free_path_note(const v1::Layers& layers, const LayerOf& layer_of, const char* none) {
  Vec3d sum(0, 0, 0);
  int n = 0;
  for (const v1::Region& r : layers.regions()) {
    const auto& ld_mm = layer_of(r).ld_mm();
    if (ld_mm.size() != 3) continue;
    sum += Vec3d(ld_mm[0], ld_mm[1], ld_mm[2]);
    ++n;
  }
  if (n == 0) return none;
  char text[96];
  std::snprintf(text, sizeof(text), "mean free path %.2f  %.2f  %.2f mm", sum[0] / n, sum[1] / n,
                sum[2] / n);
  return text;
}

std::string deep_note(const v1::Layers& layers) {
  return free_path_note(
      layers, [](const v1::Region& r) -> const auto& { return r.deep(); }, "not measured");
}

std::string slab_note(const v1::Layers& layers) {
  return free_path_note(
      layers, [](const v1::Region& r) -> const auto& { return r.shallow(); }, "not fitted");
}

std::string lobe_note(const v1::Layers& layers) {
  double low = 1e9, high = 0;
  for (const v1::Region& r : layers.regions()) {
    if (!r.specular().has_gaussian_m()) continue;
    low = std::min(low, r.specular().gaussian_m());
    high = std::max(high, r.specular().gaussian_m());
  }
  if (high == 0) return "not measured";
  char text[64];
  std::snprintf(text, sizeof(text), "lobe width %.2f\u2013%.2f rad", low, high);
  return text;
}

std::string phase_note(const v1::Layers& layers) {
  if (layers.single().g_size() != 3) return "";
  char text[64];
  std::snprintf(text, sizeof(text), "g %.2f  %.2f  %.2f", layers.single().g(0),
                layers.single().g(1), layers.single().g(2));
  return text;
}

std::array<Tile, 4> tiles(const v1::Layers& layers, const Look& look) {
  const float e = look.exposure;
  const LayerGains& on = look.gains;
  return {{{"Deep scattering", deep_note(layers), {0, 0, 0, 1}, e * kDeepGain, on.deep > 0},
           {"Shallow scattering " + times(kShallowGain),
            slab_note(layers),
            {0, 0, 1, 0},
            e * kShallowGain,
            on.shallow > 0},
           {"Single scattering " + times(kSingleGain),
            phase_note(layers),
            {0, 1, 0, 0},
            e * kSingleGain,
            on.single > 0},
           {"Specular reflection " + times(kSpecularGain),
            lobe_note(layers),
            {1, 0, 0, 0},
            e * kSpecularGain,
            on.specular > 0}}};
}

// Where the head and the four tiles go: a grid beside the head, or a row below it.
struct Layout {
  cv::Rect head;
  std::array<cv::Rect, 4> tile;
};

Layout layout_of(cv::Size size) {
  Layout l;
  const int gap = std::max(2, size.width / 200);
  if (size.width * 10 >= size.height * 13) {
    const int h = (size.height - 3 * gap) / 2, w = int(h * 0.84);
    const int x0 = size.width - 2 * w - 2 * gap;
    l.head = {0, 0, x0 - gap, size.height};
    for (int i = 0; i < 4; ++i) {
      l.tile[size_t(i)] = {x0 + (i % 2) * (w + gap), gap + (i / 2) * (h + gap), w, h};
    }
  } else {
    const int w = (size.width - 5 * gap) / 4, h = int(w * 1.2);
    l.head = {0, 0, size.width, size.height - h - 2 * gap};
    for (int i = 0; i < 4; ++i) {
      l.tile[size_t(i)] = {gap + i * (w + gap), size.height - h - gap, w, h};
    }
  }
  return l;
}

// OpenGL's rows go up.
cv::Mat3b picture_of(const Target& target) {
  cv::Mat3b bgr(target.height, target.width);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target.framebuffer.id());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, target.width, target.height, GL_BGR, GL_UNSIGNED_BYTE, bgr.data);
  cv::flip(bgr, bgr, 0);
  return bgr;
}

void put(const Target& part, cv::Rect place, const Target& whole) {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, part.framebuffer.id());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, whole.framebuffer.id());
  const int y0 = whole.height - place.y - place.height;
  glBlitFramebuffer(0, 0, part.width, part.height, place.x, y0, place.x + place.width,
                    y0 + place.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

constexpr ImU32 kWhite = IM_COL32(236, 236, 232, 255), kGrey = IM_COL32(150, 151, 152, 255);

constexpr float kNoteSize = 0.82f, kLayersSize = 0.9f;  // of the text above them
constexpr float kLeastPx = 7;  // smaller words are no words: a picture without is cleaner

float width_of(ImFont* font, float px, const std::string& words) {
  return font->CalcTextSizeA(px, FLT_MAX, 0, words.c_str()).x;
}

const std::string& note_of(const Tile& tile) {
  static const std::string off = "off";
  return tile.is_on ? tile.note : off;
}

// The text's own size; less where the widest words of any tile would not fit into one.
float caption_px(const Fonts& fonts, const std::array<Tile, 4>& tiles, int width) {
  const float px = fonts.text->FontSize;
  float widest = 1;
  for (const Tile& tile : tiles) {
    widest = std::max({widest, width_of(fonts.text, px, tile.name),
                       width_of(fonts.text, kNoteSize * px, note_of(tile))});
  }
  return px * std::min(1.f, float(width) / (widest + 1.4f * px));
}

void caption(const Fonts& fonts, const Tile& tile, cv::Rect at, float px) {
  if (kNoteSize * px < kLeastPx) return;
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  const float margin = 0.7f * px;
  const ImVec2 first(float(at.x) + margin, float(at.y + at.height) - 2.6f * px - 0.2f * margin);
  draw.AddText(fonts.text, px, first, tile.is_on ? kWhite : kGrey, tile.name.c_str());
  draw.AddText(fonts.text, kNoteSize * px, {first.x, first.y + 1.25f * px}, kGrey,
               note_of(tile).c_str());
}

// "specular + deep, as fitted": the layers that are drawn.
std::string drawn_layers(const LayerGains& gains) {
  std::string words;
  const std::pair<const char*, float> layers[] = {{"specular", gains.specular},
                                                  {"single", gains.single},
                                                  {"shallow", gains.shallow},
                                                  {"deep", gains.deep}};
  for (const auto& [name, gain] : layers) {
    if (gain > 0) words += (words.empty() ? "" : " + ") + std::string(name);
  }
  return words.empty() ? "no layer" : words + ", as fitted";
}

// Smaller where it would not fit.
void title(const Fonts& fonts, const SheetRequest& request, cv::Rect head) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  const std::string layers = drawn_layers(request.look.gains);
  const float full = fonts.text->FontSize, title_px = fonts.title->FontSize;
  const float widest = std::max(width_of(fonts.text, kLayersSize * full, layers),
                                width_of(fonts.title, title_px, request.subject));
  const float size = std::min(1.f, float(head.width) / (widest + 2.8f * full)), px = size * full;
  if (kLayersSize * px < kLeastPx) return;
  const ImVec2 first(1.4f * px, float(head.height) - 3.9f * px);
  draw.AddText(fonts.title, size * title_px, first, kWhite, request.subject.c_str());
  draw.AddText(fonts.text, kLayersSize * px, {first.x, first.y + 1.9f * px}, kGrey, layers.c_str());
}

void draw_words(const Target& sheet, const std::function<void()>& words) {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::GetIO().DisplaySize = ImVec2(float(sheet.width), float(sheet.height));
  ImGui::NewFrame();
  words();
  ImGui::Render();
  draw_to(sheet);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace

cv::Mat3b draw_head(Renderer* renderer, const Look& look, cv::Size size) {
  const Target target = make_target(size.width, size.height, GL_RGBA8, false);
  renderer->draw(look, target);
  return picture_of(target);
}

cv::Mat3b draw_sheet(Renderer* renderer, const Fonts& fonts, const v1::Layers& layers,
                     const SheetRequest& request) {
  const Layout layout = layout_of(request.size);
  const Target sheet = make_target(request.size.width, request.size.height, GL_RGBA8, false);
  draw_to(sheet);
  glClearColor(0.055f, 0.056f, 0.060f, 1.f);
  glClear(GL_COLOR_BUFFER_BIT);
  const auto place = [&](const Look& look, cv::Rect at) {
    const Target part = make_target(at.width, at.height, GL_RGBA8, false);
    renderer->draw(look, part);
    put(part, at, sheet);
  };
  place(request.look, layout.head);

  const std::array<Tile, 4> four = tiles(layers, request.look);
  const cv::Rect first = layout.tile[0];
  Look look = request.look;
  const Orbit near =
      orbit_before(renderer->face(), float(first.width) / float(first.height), 0.84f);
  look.orbit.distance_mm = near.distance_mm;
  look.orbit.shift = {0.f, 0.10f};
  look.vignette = 0.35f;
  for (size_t i = 0; i < four.size(); ++i) {
    look.gains = four[i].is_on ? four[i].gains : LayerGains{0, 0, 0, 0};
    look.exposure = four[i].exposure;
    place(look, layout.tile[i]);
  }
  draw_words(sheet, [&] {
    title(fonts, request, layout.head);
    const float px = caption_px(fonts, four, first.width);
    for (size_t i = 0; i < four.size(); ++i) caption(fonts, four[i], layout.tile[i], px);
  });
  return picture_of(sheet);
}

}  // namespace lamella::review
