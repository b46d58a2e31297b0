// A campaign on the ranks of an MPI job. Rank 0 hands out samples and writes their records; every rank runs samples,
// rank 0 too. A message that is not of this protocol ends the job: nothing that comes from another process is believed.
//
//   kHello   rank → 0   shape, program, threads: it is ready
//   kWork    0 → rank   samples: number and inputs of each
//   kRecord  rank → 0   a record, as in the file of results
//   kEnd     0 → rank   no more; what has not ended is left
//   kBye     rank → 0   its last message; it comes unasked if a signal ended the rank, and then all end
#pragma once

#include <functional>

#include "tools/mpi/mailbox.h"
#include "tools/unlatch/studies/campaign_host.h"

namespace unlatch::tools {

// The part of rank 0: it hands out samples and writes their records. Throws hil::ResultError.
void lead_campaign(MPI_Comm communicator, const CampaignTask& task, hil::ResultFile& results,
                   const std::function<void()>& finished);
// The part of every other rank: it runs samples. Throws hil::ResultError.
void follow_campaign(MPI_Comm communicator, const CampaignTask& task);

}  // namespace unlatch::tools
