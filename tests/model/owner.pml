/* States, leases, stops and the crossing of one device as the product has them (README.md). Each
   option of a process is one step of the product. If several choices are possible, the world makes
   them: people, clients, a hostile front, the device, time. With REPLAY a recorded run of the
   product makes them. */

/* A step, a choice of the world, an answer and the end of a step by their names. CLOSING: the loop
   ends there. */
#ifdef REPLAY
#include "replay.pml"
#else
#define EVENT(step) (state != CLOSING)
#define MAY(choice) true
#define TELL(answer) skip
#define DONE skip
#endif

#define PROMISE(name, holds) name = (holds); assert(name)
bit stop_wins = 1, stop_stays = 1, stop_arrives = 1, local_stop_stays = 1, force_needs_lease = 1,
    lease_needs_grant = 1, late_answer_grants_nothing = 1, silence_ends_force = 1,
    front_leaves_nothing = 1, grant_at_zero_force = 1;

/* Numbers of core::LifecycleState. */
#define INIT 1
#define IDLE 2
#define ARMED 3
#define ENGAGING 4
#define ENGAGED 5
#define RELEASING 6
#define FAULT 7
#define CLOSING 8

#define NONE SESSIONS /* no session */

/* ---- The crossing. A hostile front decides what a message says when the owner takes it: it could
   have sent that, and any number of others before and after. So the queue needs no memory but that
   of a stop. ---- */
bit front;    /* a process that the owner did not see end */
bit net_stop; /* a client of the front asked for a stop, and the owner did not take it yet */

/* ---- The owner: SessionRegistry, LeaseBook, DeviceSessions. ---- */
bit open[SESSIONS];
byte holder = NONE;
bit high, keeps, detached; /* the holder's priority; it may be resumed; it lost its stream */
byte newcomer = NONE;
bit newcomer_high, newcomer_keeps, promised; /* promised: it is the holder already */
bit admits;                                  /* the ingress takes samples of the lease */
bit asked_engage;                            /* an Engage of the holder waits for its answer */
bit stopped_locally;

/* A clear of the stop, of other faults; it has seen the newest stop; it came by
   the local control socket. 0: under way, 1: waits. */
typedef Clear { bit any, stop, fault, seen, host };
#define COMMAND 2 /* what the loop reads */
Clear clear[3];

/* The command's mailbox; "new": no tick has read it yet. */
bit held, closing, stop_new, engage_new, release_new, clear_new, tenure_new;

/* The newest record that the owner read, and whether it is younger than the newest stop, grant. */
bit seen_stop, seen_fault, seen_force, seen_held;
bit seen_newest_stop = 1, seen_tenure = 1;

/* Records on their way; how many of them are older than the newest stop, engage, clear, grant. */
typedef Record { bit stop, fault, force, held, yes, refused };
Record record[RECORDS];
short records, before_stop, before_engage, before_clear, before_grant;

/* ---- The loop: ProxyIntake, Supervisor, LifecycleMachine, Gain. ---- */
byte state = INIT;
bit gain; /* above 0 */
bit ready, stop, fault; /* a stop is latched; another fault is */
bit yes, refused;       /* the answers to the newest engage, clear */
mtype = {NO_SAMPLE, OLD, CURRENT};
mtype use = NO_SAMPLE; /* the sample in use, by its tenure */
bit box, box_new;      /* the mailbox has one of the current tenure; it is not the one in use */
bit lost = 1;          /* the sample in use is older than fade_end, or there is none */

/* ---- What only the promises read. ---- */
mtype = {NO, ASKED, YES};
mtype word = NO;        /* about the newest engage of the lease, as its client knows */
bit granted;            /* the holder was told that it has the lease */
bit local_hold;         /* a local stop came, and no local clear took it away */
bit engaged_by_holder;  /* the force that is on was engaged under this tenure */

/* ---- Choices within a step; 0 between steps. ---- */
byte who;
short i;
bit c1, c2, c3;

#define carries_force(s) (s == ENGAGING || s == ENGAGED || s == RELEASING)
#define engaged(s) (s == ENGAGING || s == ENGAGED)
/* DeviceSessions::force_is_on(). */
#define force_is_on (seen_held != held || !seen_tenure || seen_force)

inline choose_who() {
  if
  :: MAY(who == 0) -> who = 0
#if SESSIONS > 1
  :: MAY(who == 1) -> who = 1
#endif
#if SESSIONS > 2
  :: MAY(who == 2) -> who = 2
#endif
  fi
}

/* ---- What the owner's calls do. ---- */

inline new_tenure() {
  tenure_new = 1;
  seen_tenure = 0;
  before_grant = records;
  box = 0;
  box_new = 0;
  engaged_by_holder = 0;
  if
  :: use == CURRENT -> use = OLD
  :: else
  fi
}

inline end_lease() {
  holder = NONE;
  high = 0;
  keeps = 0;
  detached = 0;
  granted = 0;
  admits = 0;
  held = 0;
  word = NO;
  if
  :: asked_engage ->
    asked_engage = 0;
    TELL(ENGAGE_NO)
  :: else
  fi
}

inline take_lease(session, is_high, is_resumable) {
  holder = session;
  high = is_high;
  keeps = is_resumable;
  detached = 0
}

inline forget_newcomer() {
  newcomer = NONE;
  newcomer_high = 0;
  newcomer_keeps = 0;
  promised = 0
}

inline refuse_newcomer() {
  forget_newcomer();
  TELL(OPEN_NO)
}

inline grant_newcomer() {
  if
  :: promised
  :: else ->
    take_lease(newcomer, newcomer_high, newcomer_keeps);
    new_tenure();
    held = 1
  fi;
  PROMISE(grant_at_zero_force, !gain);
  box = 0;
  box_new = 0;
  admits = 1;
  granted = 1;
  forget_newcomer();
  TELL(OPEN_YES)
}

/* c1: of high priority, c2: resumable, c3: it names the session that has the lease. */
inline open_session() {
  if
  :: !open[who] || closing -> TELL(OPEN_NO)
  :: else ->
    if
    :: c3 && newcomer == NONE && keeps -> resume_lease()
    :: else ->
      if
      :: newcomer != NONE && c1 <= newcomer_high -> TELL(OPEN_NO)
      :: else ->
        if
        :: holder == NONE || c1 > high || (detached && c1 == high) -> wait_for_lease()
        :: else -> TELL(OPEN_NO)
        fi
      fi
    fi
  fi
}

inline resume_lease() {
  if
  :: asked_engage ->
    asked_engage = 0;
    word = NO;
    TELL(ENGAGE_NO);
    release_new = 1
  :: else
  fi;
  take_lease(who, c1, c2);
  TELL(OPEN_YES)
}

inline wait_for_lease() {
  if
  :: newcomer != NONE -> refuse_newcomer()
  :: else
  fi;
  newcomer = who;
  newcomer_high = c1;
  newcomer_keeps = c2;
  if
  :: holder != NONE ->
    end_lease();
    take_lease(who, c1, c2);
    new_tenure();
    held = 1;
    promised = 1
  :: else
  fi;
  if
  :: !force_is_on -> grant_newcomer()
  :: else
  fi
}

/* c1: its stream broke. */
inline close_session() {
  c2 = (newcomer == who);
  if
  :: c2 -> refuse_newcomer()
  :: else
  fi;
  if
  :: holder == who && open[who] ->
    if
    :: c1 && !c2 && keeps && !closing -> detached = 1
    :: else -> end_lease()
    fi
  :: else
  fi;
  open[who] = 0
}

inline post_stop() {
  stop_new = 1;
  before_stop = records;
  seen_newest_stop = 0;
  clear[0].seen = 0;
  clear[1].seen = 0;
  clear[COMMAND].seen = 0
}

inline copy_clear(from, to) {
  clear[to].any = clear[from].any;
  clear[to].stop = clear[from].stop;
  clear[to].fault = clear[from].fault;
  clear[to].seen = clear[from].seen;
  clear[to].host = clear[from].host
}

inline forget_clear(n) {
  clear[n].any = 0;
  clear[n].stop = 0;
  clear[n].fault = 0;
  clear[n].seen = 0;
  clear[n].host = 0
}

inline post_clear() {
  copy_clear(0, COMMAND);
  clear_new = 1;
  before_clear = records
}

/* c1: of every fault, else of all but a stop; c2: by the local control socket. */
inline ask_clear() {
  if
  :: !(c1 && seen_stop) && !seen_fault -> TELL(CLEAR_YES)
  :: else ->
    if
    :: c1 && seen_stop && stopped_locally && !c2 -> TELL(CLEAR_NO)
    :: else ->
      i = (clear[0].any -> 1 : 0);
      clear[i].any = 1;
      clear[i].stop = c1 && seen_stop;
      clear[i].fault = seen_fault;
      clear[i].seen = seen_newest_stop;
      clear[i].host = c2;
      if
      :: i == 0 -> post_clear()
      :: else
      fi;
      i = 0
    fi
  fi
}

inline check_lease() {
  PROMISE(lease_needs_grant,
          holder == NONE ||
          (promised && newcomer == holder) ||
          (granted && (open[holder] || detached)))
}

/* ---- The front: an honest one does some of this. ---- */
active proctype network() {
end:
  do
  :: atomic {
      EVENT(STEP_FRONT_STARTS) && !front ->
      front = 1;
      DONE
    }
  :: atomic {
      EVENT(STEP_FRONT_ASKS_STOP) && STOPS && front && !net_stop ->
      net_stop = 1;
      DONE
    }
  od
}

/* ---- The owner, but for its loop and for reading records: what comes from outside. ---- */
active proctype calls() {
end:
  do
  :: atomic {
      EVENT(STEP_SAMPLE) && front ->
      if
      :: admits && MAY(old == 0) ->
        box = 1;
        box_new = 1;
        TELL(SAMPLE_TAKEN)
      :: !admits || MAY(old)
      fi;
      DONE
    }
  :: atomic {
      EVENT(STEP_ADMIT) && front ->
      d_step {
        /* A fresh name: not that of a lease whose session is lost. */
        do
        :: who < SESSIONS && (open[who] || who == holder) -> who++
        :: else -> break
        od;
        if
        :: who < SESSIONS -> open[who] = 1
        :: else
        fi;
        who = 0
      }
      DONE
    }
  :: atomic {
      EVENT(STEP_OPEN) && front ->
      choose_who();
      if
      :: RESUMES && MAY(high) -> c1 = 1
      :: MAY(high == 0)
      fi;
      if
      :: RESUMES && MAY(keeps) -> c2 = 1
      :: MAY(keeps == 0)
      fi;
      if
      :: RESUMES && MAY(resumes) && holder != NONE -> c3 = 1
      :: MAY(resumes == 0)
      fi;
      d_step {
        open_session();
        check_lease();
        who = 0;
        c1 = 0;
        c2 = 0;
        c3 = 0
      }
      DONE
    }
  :: atomic {
      (EVENT(STEP_CLOSE) || EVENT(STEP_LOSE)) && front ->
      choose_who();
      if
      :: EVENT(STEP_LOSE) -> c1 = 1
      :: EVENT(STEP_CLOSE)
      fi;
      d_step {
        close_session();
        check_lease();
        who = 0;
        c1 = 0;
        c2 = 0
      }
      DONE
    }
  :: atomic {
      EVENT(STEP_ENGAGE) && front && !asked_engage ->
      choose_who();
      d_step {
        if
        :: holder == who && open[who] ->
          engage_new = 1;
          before_engage = records;
          asked_engage = 1;
          word = ASKED
        :: else -> TELL(ENGAGE_NO)
        fi;
        who = 0
      }
      DONE
    }
  :: atomic {
      EVENT(STEP_RELEASE) && front ->
      choose_who();
      d_step {
        if
        :: holder == who && open[who] -> release_new = 1
        :: else
        fi;
        who = 0
      }
      DONE
    }
  :: atomic {
      /* The front gave up the newest engage, and has told its client so. */
      EVENT(STEP_CANCEL) && front ->
      d_step {
        if
        :: word == ASKED || word == YES ->
          asked_engage = 0;
          release_new = 1;
          word = NO
        :: else
        fi
      }
      DONE
    }
  :: atomic {
      EVENT(STEP_STOP) && net_stop ->
      net_stop = 0;
      post_stop();
      DONE
    }
  :: atomic {
      EVENT(STEP_LOCAL_STOP) && STOPS ->
      stopped_locally = 1;
      local_hold = 1;
      post_stop();
      DONE
    }
  :: atomic {
      (EVENT(STEP_CLEAR) && front || EVENT(STEP_LOCAL_CLEAR)) && !clear[CLEARS - 1].any ->
      if
      :: EVENT(STEP_CLEAR) && front
      :: EVENT(STEP_LOCAL_CLEAR) -> c2 = 1
      fi;
      if
      :: MAY(all) -> c1 = 1
      :: MAY(all == 0)
      fi;
      d_step {
        ask_clear();
        c1 = 0;
        c2 = 0
      }
      DONE
    }
  :: atomic {
      /* What a front sent before its end is taken first, stops above all. */
      EVENT(STEP_FRONT_GONE) && front && !net_stop ->
      c1 = 1;
      d_step {
        who = 0;
        do
        :: who < SESSIONS ->
          if
          :: open[who] -> close_session()
          :: else
          fi;
          who++
        :: else -> break
        od;
        check_lease();
        PROMISE(front_leaves_nothing, newcomer == NONE && (holder == NONE || detached));
        PROMISE(stop_arrives, !net_stop);
        who = 0;
        c1 = 0;
        c2 = 0;
        front = 0
      }
      DONE
    }
  :: atomic {
      EVENT(STEP_SIGTERM) && CLOSES && !closing ->
      d_step {
        closing = 1;
        if
        :: promised -> end_lease()
        :: else
        fi;
        if
        :: newcomer != NONE -> refuse_newcomer()
        :: else
        fi;
        check_lease()
      }
      DONE
    }
  od
}

/* ---- DeviceSessions::step(): the owner reads a record. ---- */

inline see() {
  seen_stop = record[0].stop;
  seen_fault = record[0].fault;
  seen_force = record[0].force;
  seen_held = record[0].held;
  seen_newest_stop = (before_stop == 0);
  seen_tenure = (before_grant == 0);
  if
  :: !seen_stop && seen_newest_stop -> stopped_locally = 0
  :: else
  fi
}

inline answer_engage() {
  if
  :: asked_engage && before_engage == 0 ->
    asked_engage = 0;
    if
    :: record[0].yes ->
      word = YES;
      TELL(ENGAGE_YES)
    :: else ->
      word = NO;
      TELL(ENGAGE_NO)
    fi
  :: asked_engage && before_engage > 0 && MAY(gave_up_engage) ->
    asked_engage = 0;
    word = NO;
    release_new = 1;
    TELL(ENGAGE_NO)
  :: !asked_engage || before_engage > 0 && MAY(gave_up_engage == 0)
  fi
}

inline answer_clear() {
  if
  :: clear[0].any && before_clear == 0 ->
    if
    :: record[0].refused -> TELL(CLEAR_NO)
    :: else -> TELL(CLEAR_YES)
    fi;
    forget_clear(0)
  :: clear[0].any && before_clear > 0 && MAY(gave_up_clear) ->
    TELL(CLEAR_NO);
    forget_clear(0)
  :: !clear[0].any || before_clear > 0 && MAY(gave_up_clear == 0)
  fi;
  if
#if CLEARS > 1
  :: !clear[0].any && clear[1].any && MAY(gave_up_next_clear) ->
    TELL(CLEAR_NO);
    forget_clear(1)
#endif
  :: clear[0].any || !clear[1].any || MAY(gave_up_next_clear == 0)
  fi;
  d_step {
    if
    :: !clear[0].any && clear[1].any ->
      copy_clear(1, 0);
      forget_clear(1);
      post_clear()
    :: else
    fi
  }
}

inline pop(before) {
  if
  :: before > 0 -> before--
  :: else
  fi
}

inline pop_record() {
  records--;
  do
  :: i < records ->
    record[i].stop = record[i + 1].stop;
    record[i].fault = record[i + 1].fault;
    record[i].force = record[i + 1].force;
    record[i].held = record[i + 1].held;
    record[i].yes = record[i + 1].yes;
    record[i].refused = record[i + 1].refused;
    i++
  :: else -> break
  od;
  record[i].stop = 0;
  record[i].fault = 0;
  record[i].force = 0;
  record[i].held = 0;
  record[i].yes = 0;
  record[i].refused = 0;
  i = 0
}

active proctype drain() {
end:
  do
  :: atomic {
      EVENT(STEP_DRAIN) && records > 0 ->
      d_step { see() }
      if
      :: holder != NONE && !promised && MAY(expired) -> end_lease()
      :: holder == NONE || promised || MAY(expired == 0)
      fi;
      if
      :: !force_is_on && newcomer != NONE -> grant_newcomer()
      :: force_is_on && newcomer != NONE && MAY(gave_up_newcomer) ->
        if
        :: promised -> end_lease()
        :: else
        fi;
        refuse_newcomer()
      :: newcomer == NONE || force_is_on && MAY(gave_up_newcomer == 0)
      fi;
      answer_engage();
      answer_clear();
      d_step {
        pop(before_stop);
        pop(before_engage);
        pop(before_clear);
        pop(before_grant);
        pop_record();
        check_lease()
      }
      DONE
    }
  od
}

/* ---- The loop's tick. ---- */

inline take_sample() {
  if
  :: held && box && (box_new || use != CURRENT) && (!carries_force(state) || use == CURRENT) ->
    use = CURRENT;
    box_new = 0;
    lost = 0
  :: else ->
    if
    :: !(held && box) && !carries_force(state) ->
      use = NO_SAMPLE;
      lost = 1
    :: else
    fi
  fi;
  if
  :: !lost && MAY(lost) -> lost = 1
  :: lost || MAY(lost == 0)
  fi
}

/* c1: a stop came, c2: the cause of another fault is there. */
inline latch() {
  if
  :: stop_new ->
    stop_new = 0;
    c1 = 1;
    stop = 1
  :: else
  fi;
  if
  :: c2 && ready -> fault = 1
  :: else
  fi;
  if
  :: clear_new ->
    clear_new = 0;
    refused = 0;
    if
    :: clear[COMMAND].stop && (c1 || !clear[COMMAND].seen) -> refused = 1
    :: clear[COMMAND].stop && !c1 && clear[COMMAND].seen ->
      PROMISE(local_stop_stays, !stop || !local_hold || clear[COMMAND].host);
      local_hold = 0;
      stop = 0
    :: else
    fi;
    if
    :: clear[COMMAND].fault && c2 -> refused = 1
    :: clear[COMMAND].fault && !c2 -> fault = 0
    :: else
    fi;
    forget_clear(COMMAND)
  :: else
  fi
}

/* c3: force was asked for, and may be. */
inline judge_engage() {
  if
  :: engage_new && engaged(state) ->
    c3 = 1
  :: engage_new && state == ARMED && !stop && !fault && use == CURRENT && !lost &&
     MAY(judged) ->
    c3 = 1
  :: !engage_new || !engaged(state) && MAY(judged == 0)
  fi;
  d_step {
    if
    :: engage_new ->
      engage_new = 0;
      c3 = c3 && !release_new;
      yes = c3
    :: else
    fi
  }
}

/* LifecycleMachine::step(); c4: the device says that it would follow;
   c5: the gain is whole. */
inline step_machine() {
  if
  :: (stop || fault) && state != INIT && state != CLOSING && state != FAULT -> state = FAULT
  :: else ->
    if
    :: state == INIT ->
      if
      :: closing -> state = CLOSING
      :: !closing && ready -> state = IDLE
      :: else
      fi
    :: state == IDLE ->
      if
      :: closing -> state = CLOSING
      :: !closing && held && c4 -> state = ARMED
      :: else
      fi
    :: state == ARMED ->
      if
      :: closing -> state = CLOSING
      :: !closing && (!held || !c4) -> state = IDLE
      :: !closing && held && c4 && c3 ->
        state = ENGAGING;
        engaged_by_holder = 1
      :: else
      fi
    :: engaged(state) ->
      if
      :: closing || release_new || !held || tenure_new || !c4 -> state = RELEASING
      :: else ->
        if
        :: lost -> state = ARMED
        :: !lost && state == ENGAGING && c5 -> state = ENGAGED
        :: else
        fi
      fi
    :: state == RELEASING ->
      if
      :: gain
      :: !gain && closing -> state = CLOSING
      :: !gain && !closing && held && c4 -> state = ARMED
      :: !gain && !closing && !(held && c4) -> state = IDLE
      fi
    :: state == FAULT ->
      if
      :: closing -> state = CLOSING
      :: !closing && !stop && !fault -> state = IDLE
      :: else
      fi
    fi
  fi
}

inline move_gain() {
  if
  :: state == FAULT || state == CLOSING || lost -> gain = 0
  :: else ->
    if
    :: engaged(state) -> gain = 1
    :: !engaged(state) && (!gain || MAY(gain)) /* it falls */
    :: !engaged(state) && gain && MAY(gain == 0) -> gain = 0
    fi
  fi
}

inline tell_record() {
  if
  :: records < RECORDS ->
    record[records].stop = stop;
    record[records].fault = fault;
    record[records].force = gain;
    record[records].held = held;
    record[records].yes = yes;
    record[records].refused = refused;
    records++
  :: else /* it is lost */
  fi
}

/* What is not looked at any more is 0, so that fewer states differ. */
inline forget_answered() {
  yes = yes && asked_engage;
  refused = refused && clear[0].any;
  engaged_by_holder = engaged_by_holder && engaged(state)
}

inline check_tick() {
  PROMISE(stop_wins, !(c1 || stop) || (!gain && !engaged(state) && state != RELEASING));
  PROMISE(stop_stays, !c1 || stop);
  PROMISE(force_needs_lease,
          (!gain || carries_force(state)) &&
          (!engaged(state) || (held && granted && engaged_by_holder)));
  PROMISE(late_answer_grants_nothing, !engaged(state) || word == ASKED || word == YES);
  PROMISE(silence_ends_force, !lost || !gain)
}

active proctype loop() {
  bit c4, c5;
end:
  do
  :: atomic {
      EVENT(STEP_TICK) ->
      take_sample();
      if
      :: !ready && MAY(ready) -> ready = 1
      :: ready || MAY(ready == 0)
      fi;
      if
      :: FAULTS && MAY(cause) -> c2 = 1
      :: MAY(cause == 0)
      fi;
      if
      :: held && MAY(armed) -> c4 = 1
      :: !held || MAY(armed == 0)
      fi;
      if
      :: state == ENGAGING && MAY(state == ENGAGED) -> c5 = 1
      :: state != ENGAGING || MAY(state != ENGAGED)
      fi;
      d_step { latch() }
      judge_engage();
      d_step {
        step_machine();
        release_new = 0;
        tenure_new = 0
      }
      move_gain();
      d_step {
        tell_record();
        check_tick();
        forget_answered();
        c1 = 0;
        c2 = 0;
        c3 = 0;
        c4 = 0;
        c5 = 0
      }
      DONE
    }
  od
}
