#include "tools/mpi/ranks.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "tools/program/exit_codes.h"

namespace unlatch::tools {
namespace {

constexpr int kReady = -1;  // instead of an exit code

}  // namespace

Ranks::Ranks(int& argc, char**& argv) {
  int given = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &given);
  MPI_Comm_dup(MPI_COMM_WORLD, &communicator_);
  MPI_Comm_rank(communicator_, &rank_);
  if (rank_ != 0) mute();
}

void Ranks::mute() {
  stderr_ = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0);
  kept_ = memfd_create("standard error", MFD_CLOEXEC);
  const int nothing = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (kept_ >= 0) dup2(kept_, STDERR_FILENO);
  if (nothing >= 0) {
    dup2(nothing, STDOUT_FILENO);
    close(nothing);
  }
}

void Ranks::speak() const {
  std::fflush(stderr);
  if (kept_ < 0) return;
  char host[MPI_MAX_PROCESSOR_NAME] = "";
  int length = 0;
  MPI_Get_processor_name(host, &length);
  std::string text =
      "rank " + std::to_string(rank_) + " on " + std::string(host, static_cast<std::size_t>(length)) + ": ";
  char buffer[4096];
  off_t at = 0;
  for (ssize_t got = 0; (got = pread(kept_, buffer, sizeof buffer, at)) > 0; at += got)
    text.append(buffer, static_cast<std::size_t>(got));
  if (text.back() != '\n') text += '\n';
  for (std::size_t put = 0; put < text.size();) {
    const ssize_t count = write(stderr_, text.data() + put, text.size() - put);
    if (count <= 0) return;
    put += static_cast<std::size_t>(count);
  }
}

Ranks::Outcome Ranks::compare(int code) const {
  int ranks = 1;
  MPI_Comm_size(communicator_, &ranks);
  std::vector<int> codes(static_cast<std::size_t>(ranks));
  MPI_Allgather(&code, 1, MPI_INT, codes.data(), 1, MPI_INT, communicator_);
  const auto first = std::find_if(codes.begin(), codes.end(), [](int other) { return other != kReady; });
  if (first == codes.end()) return {};
  const bool none_is_ready = std::find(codes.begin(), codes.end(), kReady) == codes.end();
  return {static_cast<int>(first - codes.begin()), *first != kExitDone || none_is_ready ? *first : kExitFailed};
}

void Ranks::begin() {
  const Outcome outcome = compare(kReady);
  begun_ = true;
  if (outcome.rank < 0) return;
  ended_ = true;
  throw OtherRankFailed{outcome.code};
}

int Ranks::finish(int code) {
  if (!begun_) {
    const Outcome outcome = compare(code);
    code = outcome.code;
    if (rank_ == outcome.rank && code != kExitDone) speak();
  } else if (!ended_) {
    speak();
    MPI_Abort(communicator_, code == kExitDone ? kExitFailed : code);
  }
  std::fflush(stdout);
  MPI_Comm_free(&communicator_);
  MPI_Finalize();
  return code;
}

}  // namespace unlatch::tools
