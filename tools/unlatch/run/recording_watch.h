// Reports once, and immediately, that a recording has stopped, so that no long run is lost.
#pragma once

#include "hil/run/recording/recorder.h"
#include "tools/common/terminal.h"

namespace unlatch::tools {

class RecordingWatch {
 public:
  explicit RecordingWatch(const hil::Recorder* recorder) : recorder_(recorder) {}  // null: there is none

  void look(Progress& progress) {
    if (recorder_ == nullptr || !recorder_->has_failed()) return;
    recorder_ = nullptr;
    progress.clear();
    const char* const text = "the recording has stopped: its file cannot be written any more; the run goes on";
    std::fprintf(stderr, "%s\n", paint(stderr, Colour::kRed, text).c_str());
  }

 private:
  const hil::Recorder* recorder_;
};

}  // namespace unlatch::tools
