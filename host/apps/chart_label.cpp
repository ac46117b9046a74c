#include "apps/chart_label.h"

#include <fmt/format.h>

namespace lamella::apps {

namespace {

std::string escaped(const std::string& words) {
  std::string out;
  for (const char c : words) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string chart_head(double width, double height) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "width=\"{0:.0f}\" height=\"{1:.0f}\" font-family=\"Inter, Helvetica, Arial, "
      "sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fbfaf8\"/>\n",
      width, height);
}

std::string chart_label(double x, double y, const std::string& words, double size,
                        const char* colour, const char* anchor) {
  return fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:g}\" fill=\"{}\" text-anchor=\"{}\">"
      "{}</text>\n",
      x, y, size, colour, anchor, escaped(words));
}

}  // namespace lamella::apps
