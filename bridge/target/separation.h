/* The separation sequence of strap-on boosters in C99: commands at the ticks at which tools/fsw/separation_sequence.cc
 * gives them, for vehicles without an attitude loop. */
#ifndef UNLATCH_TARGET_SEPARATION_H_
#define UNLATCH_TARGET_SEPARATION_H_

#include "bridge/participant/participant.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { UNLATCH_SEPARATION_BOOSTERS = 9 }; /* at most */

typedef struct unlatch_separation {
  int steps;                                       /* of the cyclogram that are done */
  int64_t contact_ns[UNLATCH_SEPARATION_BOOSTERS]; /* -1: it has not fired */
  int is_open[UNLATCH_SEPARATION_BOOSTERS];        /* its nozzle */
} unlatch_separation;

void unlatch_separation_begin(unlatch_separation* sequence);
/* Commands for the tick of p->state; to be called once for each. */
void unlatch_separation_update(unlatch_separation* sequence, unlatch_participant* p);

#ifdef __cplusplus
}
#endif

#endif /* UNLATCH_TARGET_SEPARATION_H_ */
