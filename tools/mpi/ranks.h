// The ranks of an MPI job as one program: one standard output, one message for each mistake, one exit code.
#pragma once

#include "tools/mpi/mailbox.h"

namespace unlatch::tools {

// Initialises MPI. Of ranks other than 0 standard output is lost, and standard error is kept until they fail.
class Ranks {
 public:
  Ranks(int& argc, char**& argv);
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  [[nodiscard]] int get_rank() const { return rank_; }
  [[nodiscard]] MPI_Comm get_communicator() const { return communicator_; }

  // All ranks are ready for the common work: returns on all of them, or throws OtherRankFailed on those that were.
  void begin();
  // The common work is done on this rank; what fails later, fails on it alone.
  void end() { ended_ = true; }
  // Ends MPI. `code`: of this rank. Returns the exit code of this process. A rank that has failed says why, once of all
  // that failed alike before begin(); one that fails between begin() and end() ends the job.
  int finish(int code);

 private:
  struct Outcome {
    int rank = -1;  // of the first that is not ready; -1: all are
    int code = 0;   // its exit code
  };
  [[nodiscard]] Outcome compare(int code) const;
  void mute();
  void speak() const;  // what was kept

  int rank_ = 0;
  MPI_Comm communicator_ = MPI_COMM_NULL;
  bool begun_ = false, ended_ = false;
  int stderr_ = -1;  // file descriptor of the real one, -1: it is not muted
  int kept_ = -1;    // file in memory
};

// Another rank failed before the common work, and says why.
struct OtherRankFailed {
  int code;
};

}  // namespace unlatch::tools
