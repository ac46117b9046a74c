// A screen to draw on, or one in memory where there is none.
#pragma once

namespace lamella::review {

// Where neither DISPLAY nor WAYLAND_DISPLAY is set: runs this same command line again under
// `xvfb-run`, and does not come back. Throws Error where xvfb-run is not installed.
void ensure_display();

}  // namespace lamella::review
