#pragma once
/* Steps of the product, as record_steps.cpp writes them and the model's verifier reads them. */

enum {
  STEP_RUN, /* a run begins; not a step */
  STEP_TICK,
  STEP_DRAIN, /* the owner reads a record */
  STEP_SAMPLE,
  STEP_ADMIT,
  STEP_OPEN,
  STEP_CLOSE,
  STEP_LOSE,
  STEP_ENGAGE,
  STEP_RELEASE,
  STEP_CANCEL,
  STEP_CLEAR,
  STEP_FRONT_STARTS,
  STEP_FRONT_ASKS_STOP, /* a client of it */
  STEP_STOP,            /* the owner takes that */
  STEP_FRONT_GONE,
  STEP_LOCAL_STOP,
  STEP_LOCAL_CLEAR,
  STEP_SIGTERM,
  STEP_END /* of all runs; not a step */
};

/* Answers within a step, and a sample that was accepted. */
enum {
  ENGAGE_YES = 1,
  ENGAGE_NO = 2,
  OPEN_YES = 4,
  OPEN_NO = 8,
  CLEAR_YES = 16,
  CLEAR_NO = 32,
  SAMPLE_TAKEN = 64
};

struct Step {
  unsigned char event;
  /* Choices of the world. */
  unsigned char who;                                       /* the session */
  unsigned char high, keeps, resumes;                      /* an opening */
  unsigned char old;                                       /* a sample's epoch */
  unsigned char all;                                       /* a clear is of all faults */
  unsigned char ready, cause, armed, judged;               /* a tick */
  unsigned char expired, gave_up_newcomer, gave_up_engage; /* a record */
  unsigned char gave_up_clear, gave_up_next_clear;
  /* The product's state after the step. */
  unsigned char state, gain, lost, stop, fault, holder, detached, told;
};
