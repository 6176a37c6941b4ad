
/* --- Rules: the same for all components. R1 to R15 are those of docs/verify.md. ------------- */

#ifdef CLAIM_ONLY
#define ENSURE(x) skip
#else
#define ENSURE(x) assert(x)
#endif
#define NONE 255
#define STARTING 0
#define RUNNING 1
#define STOPPING 2
#define STOPPED 3
/* where a task is */
#define ABSENT 0
#define SLEEP 1
#define BEGIN 2
#define CODEL 3
#define FETCH 4
#define WAKE 5
/* life of an activity */
#define INIT 0
#define RUN 1
#define STOP 2
#define CANCELLED 3
/* modes of a place: of two that meet, the greater one stays */
#define DONE 0
#define ASLEEP 1
#define PAUSED 2
#define READY 3
/* ends */
#define SUCCESS 1
#define INTERRUPTED 2
#define FAILED 3
/* answers of codels */
#define GO 0
#define PAUSE 1
#define SLEEPS 2
#define ETHER 3
#define OK 4
#define FAIL 5
/* what comes next for a request; below, an item of its work plus one */
#define WAKE_OK 252
#define WAKE_BAD 253
#define CONCLUDE 254

typedef Place { byte state; byte mode }
typedef Activity {
  byte machine; byte life; bool at_stop; bool asked; byte end; byte count; Place p[PLACES]
}
/* r: those that run, then those sent to the task, then those that ended. */
typedef Task {
  byte at; bool tick; byte cur; byte place; byte nr; byte ni; byte no; Activity r[RUNS];
  bool runnable; bool again; bool moved; bool late; byte young = 2; int fired
}

Task T[TASKS];
byte phase = FIRST_PHASE;
byte step;                      /* the task that starts or stops; TASKS: activities stop */
byte pending[PENDING]; byte np; /* accepted activities, the oldest first */
byte pc[SERVICES]; byte nw;     /* requests being served */
byte held[CONTEXTS];            /* the node that each executes, plus one */
byte want[CONTEXTS];            /* and the one that it waits for */
byte q[CONTEXTS]; byte nq;      /* who waits, in order of arrival */
bool ran[SERVICES];
bool failed;
byte count[SERVICES];           /* activities of each service */
byte activities;                /* of services, sent and not collected */
byte chosen;
#ifdef TIME
int since[CONTEXTS];            /* time since each began its node */
int clock[TASKS];               /* time since the last tick */
#define BEGINS(c) since[c] = 0
#else
#define BEGINS(c) skip
#endif

/* Indices of loops. */
hidden short li, la, lb, lc, l_free, mi, mj, mk, hi, h_stop, gr, gp, gran, gn, g_found, ci, cj;
hidden short bi, bk, bt, bs, b_at, ii, it, ix, i_changed, ei, ek, et, ex, e_blocked, ui, ut, used;
hidden short xi, xk, r_again, r_moved, r_tick, f_ok, si, ski, oi, ot;
hidden byte gone[PENDING];

#define MACHINE(t, x) T[t].r[x].machine
#define OF_SERVICE(t, x) (M_SERVICE[MACHINE(t, x)] != NONE)
#define LISTED(t) (T[t].nr + T[t].ni + T[t].no)
#define WORKER(s) (TASK_COUNT + (s))

/* R5 */
inline look_free(n, ahead) {
  l_free = 1; li = 0;
  do
  :: li < CONTEXTS ->
     if :: held[li] != 0 && CONFLICT[(n) * NODES + held[li] - 1] -> l_free = 0 :: else -> skip fi;
     li++
  :: else -> break
  od;
  li = 0;
  do
  :: li < (ahead) ->
     if :: CONFLICT[(n) * NODES + want[q[li]] - 1] -> l_free = 0 :: else -> skip fi;
     li++
  :: else -> break
  od
}
inline enter(c, n) {
  look_free(n, nq);
  if
  :: l_free -> held[c] = (n) + 1; BEGINS(c)
  :: else -> want[c] = (n) + 1; q[nq] = c; nq++
  fi
}
inline leave(c) {
  held[c] = 0; BEGINS(c); la = 0;
  do
  :: la < nq ->
     lc = q[la];
     look_free(want[lc] - 1, la);
     if
     :: l_free ->
        held[lc] = want[lc]; want[lc] = 0; BEGINS(lc); lb = la;
        do :: lb + 1 < nq -> q[lb] = q[lb + 1]; lb++ :: else -> break od;
        nq--; q[nq] = 0
     :: else -> la++
     fi
  :: else -> break
  od
}

/* Lists of activities. */
inline clear_run(t, x) {
  T[t].r[x].machine = 0; T[t].r[x].life = INIT; T[t].r[x].at_stop = 0; T[t].r[x].asked = 0;
  T[t].r[x].end = 0; T[t].r[x].count = 0; ci = 0;
  do
  :: ci < PLACES -> T[t].r[x].p[ci].state = 0; T[t].r[x].p[ci].mode = 0; ci++
  :: else -> break
  od
}
inline copy_run(t, from, to) {
  T[t].r[to].machine = T[t].r[from].machine; T[t].r[to].life = T[t].r[from].life;
  T[t].r[to].at_stop = T[t].r[from].at_stop; T[t].r[to].asked = T[t].r[from].asked;
  T[t].r[to].end = T[t].r[from].end; T[t].r[to].count = T[t].r[from].count; ci = 0;
  do
  :: ci < PLACES ->
     T[t].r[to].p[ci].state = T[t].r[from].p[ci].state;
     T[t].r[to].p[ci].mode = T[t].r[from].p[ci].mode; ci++
  :: else -> break
  od
}
inline remove_run(t, x) {       /* the counters are the caller's */
  cj = x;
  do
  :: cj + 1 < LISTED(t) -> copy_run(t, cj + 1, cj); cj++
  :: else -> break
  od;
  clear_run(t, cj)
}
inline to_outbox(t, x) {        /* r[RUNS - 1] is always free for this */
  copy_run(t, x, LISTED(t)); cj = x;
  do
  :: cj < LISTED(t) -> copy_run(t, cj + 1, cj); cj++
  :: else -> break
  od;
  clear_run(t, cj);
  T[t].nr--; T[t].no++
}
inline send(t, m, stops) {
  cj = LISTED(t);
  do
  :: cj > T[t].nr + T[t].ni -> copy_run(t, cj - 1, cj); cj--
  :: else -> break
  od;
  clear_run(t, cj);
  T[t].r[cj].machine = m; T[t].r[cj].at_stop = stops; T[t].ni++
}
inline wake(t) { T[t].runnable = T[t].runnable || (PERIOD[t] == 0) }
inline wake_all(but) {
  xi = 0;
  do
  :: xi < TASK_COUNT ->
     if
     :: xi != (but) && PERIOD[xi] == 0 && T[xi].at != ABSENT -> T[xi].runnable = 1
     :: else -> skip
     fi;
     xi++
  :: else -> break
  od
}

/* R8 */
inline rest(t) {
  r_again = T[t].again; r_moved = T[t].moved; T[t].again = 0; T[t].moved = 0;
  T[t].cur = 0; T[t].place = 0;
  r_tick = (PERIOD[t] == 0 || !r_again);
  if
  :: !r_again -> T[t].young = 0
  :: r_again && T[t].young > 1 -> T[t].young = 1
  :: else -> skip
  fi;
  if
  :: r_again || (PERIOD[t] == 0 && r_moved) -> T[t].at = BEGIN; T[t].tick = r_tick
  :: else ->
     if
     :: T[t].late -> T[t].late = 0; T[t].at = BEGIN; T[t].tick = 1
     :: else -> T[t].at = SLEEP; T[t].tick = 0
     fi
  fi
}
inline hand_back(t) {
  hi = 0; h_stop = 0;
  do
  :: hi < T[t].nr && !h_stop ->
     if
     :: T[t].r[hi].end == 0 -> hi++
     :: T[t].r[hi].end == SUCCESS && M_FETCH[MACHINE(t, hi)] != 0 ->
        T[t].at = FETCH; T[t].cur = hi; T[t].place = 0; T[t].tick = 0;
        enter(t, M_FETCH[MACHINE(t, hi)] - 1); h_stop = 1
     :: else -> to_outbox(t, hi)
     fi
  :: else -> break
  od;
  if
  :: h_stop -> skip
  :: else ->
     if
     :: APERIODIC - (PERIOD[t] == 0) > 0 ->
        T[t].at = WAKE; T[t].cur = 0; T[t].place = 0; T[t].tick = 0
     :: else -> rest(t)
     fi
  fi
}

/* R7: places that ended go, those in one state become one. */
inline merge(t, x) {
  mi = 0; mk = 0;
  do
  :: mi < T[t].r[x].count ->
     if
     :: T[t].r[x].p[mi].mode == DONE -> skip
     :: else ->
        mj = 0;
        do
        :: mj < mk && T[t].r[x].p[mj].state != T[t].r[x].p[mi].state -> mj++
        :: else -> break
        od;
        if
        :: mj < mk && T[t].r[x].p[mi].mode > T[t].r[x].p[mj].mode ->
           T[t].r[x].p[mj].mode = T[t].r[x].p[mi].mode
        :: mj < mk && T[t].r[x].p[mi].mode <= T[t].r[x].p[mj].mode -> skip
        :: else ->
           T[t].r[x].p[mk].state = T[t].r[x].p[mi].state;
           T[t].r[x].p[mk].mode = T[t].r[x].p[mi].mode; mk++
        fi
     fi;
     mi++
  :: else -> break
  od;
  mi = mk;
  do
  :: mi < T[t].r[x].count -> T[t].r[x].p[mi].state = 0; T[t].r[x].p[mi].mode = 0; mi++
  :: else -> break
  od;
  T[t].r[x].count = mk
}

/* R7: the next ready place from activity gr, place gp on. */
inline go_on(t) {
  g_found = 0;
  do
  :: gr < T[t].nr && !g_found ->
     if
     :: T[t].r[gr].end != 0 -> skip
     :: else ->
        do
        :: gp < T[t].r[gr].count && T[t].r[gr].p[gp].mode != READY -> gp++
        :: else -> break
        od;
        if
        :: gp < T[t].r[gr].count ->
           gn = M_CODEL[MACHINE(t, gr) * STATES + T[t].r[gr].p[gp].state];
           if
           :: gn != 0 ->
              T[t].at = CODEL; T[t].cur = gr; T[t].place = gp; T[t].tick = 0;
              enter(t, gn - 1); g_found = 1
           :: else -> T[t].r[gr].end = FAILED
           fi
        :: gp >= T[t].r[gr].count && gran ->
           merge(t, gr);
           if :: T[t].r[gr].count == 0 -> T[t].r[gr].end = SUCCESS :: else -> skip fi
        :: else -> skip
        fi
     fi;
     if :: g_found -> skip :: else -> gr++; gp = 0; gran = 0 fi
  :: else -> break
  od;
  if
  :: g_found -> skip
  :: else ->
     gr = 0;
     do
     :: gr < T[t].nr ->
        if :: T[t].r[gr].end != 0 -> T[t].moved = 1 :: else -> skip fi;
        gr++
     :: else -> break
     od;
     if :: T[t].moved -> hand_back(t) :: else -> rest(t) fi
  fi
}

/* R4: a state becomes the only active one. */
inline enter_state(t, x, s) {
  bi = 0;
  do
  :: bi < T[t].r[x].count -> T[t].r[x].p[bi].state = 0; T[t].r[x].p[bi].mode = 0; bi++
  :: else -> break
  od;
  if
  :: M_CODEL[MACHINE(t, x) * STATES + (s)] != 0 ->
     T[t].r[x].p[0].state = s; T[t].r[x].p[0].mode = READY; T[t].r[x].count = 1
  :: else -> T[t].r[x].count = 0; T[t].r[x].end = SUCCESS
  fi
}
/* R14: an external event. */
inline receive(t, x, s) {
  if
  :: (T[t].r[x].life == RUN || T[t].r[x].life == STOP) && T[t].r[x].end == 0 &&
     M_CODEL[MACHINE(t, x) * STATES + (s)] != 0 ->
     bi = 0; bk = 0;
     do
     :: bi < T[t].r[x].count ->
        if
        :: T[t].r[x].p[bi].mode == ASLEEP -> skip
        :: else ->
           T[t].r[x].p[bk].state = T[t].r[x].p[bi].state;
           T[t].r[x].p[bk].mode = T[t].r[x].p[bi].mode; bk++
        fi;
        bi++
     :: else -> break
     od;
     bi = bk;
     do
     :: bi < T[t].r[x].count -> T[t].r[x].p[bi].state = 0; T[t].r[x].p[bi].mode = 0; bi++
     :: else -> break
     od;
     T[t].r[x].count = bk; bi = 0;
     do
     :: bi < bk && T[t].r[x].p[bi].state != (s) -> bi++
     :: else -> break
     od;
     T[t].r[x].p[bi].state = s; T[t].r[x].p[bi].mode = READY;
     if :: bi == bk -> T[t].r[x].count = bk + 1 :: else -> skip fi
  :: else -> skip
  fi
}
/* R4 */
inline prepare(t, x, ticks) {
  if
  :: T[t].r[x].life == CANCELLED -> T[t].r[x].end = INTERRUPTED
  :: T[t].r[x].life == INIT && (ticks) && T[t].r[x].at_stop ->
     T[t].r[x].life = STOP; enter_state(t, x, STOP_STATE)
  :: T[t].r[x].life == INIT && (ticks) && !T[t].r[x].at_stop ->
     T[t].r[x].life = RUN; enter_state(t, x, START_STATE)
  :: T[t].r[x].life == RUN && T[t].r[x].asked ->
     T[t].r[x].life = STOP; enter_state(t, x, STOP_STATE);
     if
     :: T[t].r[x].end != 0 && OF_SERVICE(t, x) -> T[t].r[x].end = INTERRUPTED
     :: else -> skip
     fi
  :: ((T[t].r[x].life == RUN && !T[t].r[x].asked) || T[t].r[x].life == STOP) && (ticks) ->
     bi = 0;
     do
     :: bi < T[t].r[x].count ->
        if
        :: T[t].r[x].p[bi].mode == PAUSED -> T[t].r[x].p[bi].mode = READY
        :: else -> skip
        fi;
        bi++
     :: else -> break
     od
  :: else -> skip
  fi
}
/* R3 */
inline begin(t) {
  bt = (T[t].at != BEGIN || T[t].tick);
  T[t].runnable = 0; T[t].nr = T[t].nr + T[t].ni; T[t].ni = 0;
  b_at = T[t].fired; T[t].fired = 0; T[t].tick = 0;
  if
  :: T[t].nr == 0 -> rest(t)
  :: else ->
     bs = 0;
     do
     :: bs < T[t].nr ->
        ski = 0;
        do
        :: ski < SINKS ->
           if :: (b_at >> ski) & 1 -> receive(t, bs, SINK[ski]) :: else -> skip fi;
           ski++
        :: else -> break
        od;
        prepare(t, bs, bt);
        bs++
     :: else -> break
     od;
     gr = 0; gp = 0; gran = 0;
     go_on(t)
  fi
}
/* R6 */
inline task_returns(t, kind, to) {
  leave(t);
  if
  :: T[t].at == FETCH -> to_outbox(t, T[t].cur); hand_back(t)
  :: else ->
     gr = T[t].cur; gp = T[t].place; gran = 1;
     if
     :: (kind) == GO && BY_PERIOD && PERIOD[t] != 0 ->
        T[t].r[gr].p[gp].state = to; T[t].r[gr].p[gp].mode = PAUSED
     :: (kind) == GO && !(BY_PERIOD && PERIOD[t] != 0) ->
        T[t].again = 1; T[t].moved = 1;
        T[t].r[gr].p[gp].state = to; T[t].r[gr].p[gp].mode = READY
     :: (kind) == PAUSE -> T[t].r[gr].p[gp].state = to; T[t].r[gr].p[gp].mode = PAUSED
     :: (kind) == SLEEPS -> T[t].r[gr].p[gp].state = to; T[t].r[gr].p[gp].mode = ASLEEP
     :: (kind) == ETHER -> T[t].r[gr].p[gp].mode = DONE
     :: else -> T[t].r[gr].end = FAILED
     fi;
     if
     :: T[t].r[gr].end == FAILED -> gr++; gp = 0; gran = 0
     :: else -> gp++
     fi;
     go_on(t)
  fi
}

/* R12, R13 */
inline stop(t, x) {
  if
  :: T[t].r[x].life == INIT -> T[t].r[x].life = CANCELLED; i_changed = 1
  :: T[t].r[x].life == RUN && !T[t].r[x].asked && T[t].r[x].end == 0 ->
     T[t].r[x].asked = 1; i_changed = 1
  :: else -> skip
  fi
}
inline interrupt(s, but) {
  ii = 0;
  do
  :: ii < np ->
     if :: ii != (but) && INTERRUPTS[(s) * SERVICES + pending[ii]] -> gone[ii] = 1 :: else -> skip fi;
     ii++
  :: else -> break
  od;
  it = 0;
  do
  :: it < TASK_COUNT ->
     i_changed = 0; ix = 0;
     do
     :: ix < T[it].nr + T[it].ni ->
        if
        :: OF_SERVICE(it, ix) && INTERRUPTS[(s) * SERVICES + M_SERVICE[MACHINE(it, ix)]] ->
           stop(it, ix)
        :: else -> skip
        fi;
        ix++
     :: else -> break
     od;
     if :: i_changed -> wake(it) :: else -> skip fi;
     it++
  :: else -> break
  od
}
inline all_stay() {
  ei = 0;
  do :: ei < PENDING -> gone[ei] = 0; ei++ :: else -> break od
}
inline drop_gone(lost) {
  ei = 0; ek = 0;
  do
  :: ei < np ->
     if
     :: gone[ei] -> count[pending[ei]] = count[pending[ei]] - lost
     :: else -> pending[ek] = pending[ei]; ek++
     fi;
     ei++
  :: else -> break
  od;
  do :: np > ek -> np--; pending[np] = 0 :: else -> break od
}
inline examine() {
  all_stay();
  ei = np;
  do
  :: ei > 0 ->
     ei--;
     if :: gone[ei] -> skip :: else -> interrupt(pending[ei], ei) fi
  :: else -> break
  od;
  drop_gone(1);
  all_stay();
  ex = 0;
  do
  :: ex < np ->
     e_blocked = 0; et = 0;
     do
     :: et < TASK_COUNT ->
        ek = 0;
        do
        :: ek < LISTED(et) ->
           if
           :: (T[et].r[ek].life == RUN || T[et].r[ek].life == STOP) && OF_SERVICE(et, ek) &&
              INTERRUPTS[pending[ex] * SERVICES + M_SERVICE[MACHINE(et, ek)]] -> e_blocked = 1
           :: else -> skip
           fi;
           ek++
        :: else -> break
        od;
        et++
     :: else -> break
     od;
     if
     :: e_blocked -> skip
     :: else ->
        gone[ex] = 1; et = M_TASK[S_MACHINE[pending[ex]] - 1];
        send(et, S_MACHINE[pending[ex]] - 1, 0); activities++; wake(et)
     fi;
     ex++
  :: else -> break
  od;
  drop_gone(0)
}

/* R9 */
inline collect_one(t) {
  do
  :: T[t].no > 0 ->
     oi = T[t].nr + T[t].ni; ot = MACHINE(t, oi);
     if
     :: OF_SERVICE(t, oi) ->
        activities--; count[M_SERVICE[ot]]--;
        if
        :: T[t].r[oi].life != CANCELLED && T[t].r[oi].end == SUCCESS &&
           S_ORDERED[M_SERVICE[ot]] -> ran[M_SERVICE[ot]] = 1
        :: else -> skip
        fi;
        remove_run(t, oi); T[t].no--
     :: else ->
        failed = failed || (T[t].r[oi].end == FAILED);
        used = (T[t].r[oi].asked && T[t].r[oi].life == RUN &&
                M_CODEL[ot * STATES + STOP_STATE] != 0);
        remove_run(t, oi); T[t].no--;
        if :: used -> send(t, ot, 1); wake(t) :: else -> skip fi
     fi
  :: else -> break
  od
}
inline collect_all() {
  ut = 0;
  do :: ut < TASK_COUNT -> collect_one(ut); ut++ :: else -> break od;
  examine()
}

/* R10, R11 */
inline answer(s) { pc[s] = 0; nw-- }
inline finish(s, ok) {
  if
  :: APERIODIC > 0 -> if :: ok -> pc[s] = WAKE_OK :: else -> pc[s] = WAKE_BAD fi
  :: else ->
     if
     :: (ok) && !(S_ABORTS[s] && !S_ORDERED[s]) -> pc[s] = CONCLUDE
     :: else -> answer(s)
     fi
  fi
}
inline work(s, item) {
  if
  :: (item) == S_COUNT[s] -> finish(s, 1)
  :: else -> pc[s] = (item) + 1; enter(WORKER(s), WORK[S_FIRST[s] + (item)] - 1)
  fi
}
inline request(s) {
  f_ok = 1;
  if
  :: S_MACHINE[s] == 0 -> skip
  :: else ->                    /* a slot of the task */
     ut = M_TASK[S_MACHINE[s] - 1]; used = 0; ui = 0;
     do
     :: ui < LISTED(ut) -> if :: OF_SERVICE(ut, ui) -> used++ :: else -> skip fi; ui++
     :: else -> break
     od;
     ui = 0;
     do
     :: ui < np -> if :: M_TASK[S_MACHINE[pending[ui]] - 1] == ut -> used++ :: else -> skip fi; ui++
     :: else -> break
     od;
     ui = 0;
     do
     :: ui < SERVICES ->
        if
        :: pc[ui] != 0 && pc[ui] != WAKE_BAD && S_MACHINE[ui] != 0 ->
           if :: M_TASK[S_MACHINE[ui] - 1] == ut -> used++ :: else -> skip fi
        :: else -> skip
        fi;
        ui++
     :: else -> break
     od;
     f_ok = (used < SLOTS)
  fi;
  ui = 0;
  do
  :: ui < SERVICES ->
     if
     :: (AFTER[(s) * SERVICES + ui] && !ran[ui]) || (BEFORE[(s) * SERVICES + ui] && ran[ui]) ->
        f_ok = 0
     :: else -> skip
     fi;
     ui++
  :: else -> break
  od;
  nw++;
  if :: f_ok -> work(s, 0) :: else -> finish(s, 0) fi
}
inline worker_returns(s, kind) {
  leave(WORKER(s)); si = pc[s];
  if :: (kind) == OK -> work(s, si) :: else -> finish(s, 0) fi
}
inline proceed(s) {
  if
  :: pc[s] == WAKE_OK -> wake_all(NONE); pc[s] = CONCLUDE
  :: pc[s] == WAKE_BAD -> wake_all(NONE); answer(s)
  :: else ->
     answer(s);
     if
     :: S_MACHINE[s] != 0 ->
        if :: phase == RUNNING -> pending[np] = s; np++; count[s]++; examine() :: else -> skip fi
     :: else ->
        ran[s] = ran[s] || S_ORDERED[s];
        all_stay(); interrupt(s, NONE); drop_gone(1); examine()
     fi
  fi
}

/* R15 */
inline kill() {
  phase = STOPPING; step = TASK_COUNT;
  do :: np > 0 -> np--; count[pending[np]]--; pending[np] = 0 :: else -> break od;
  it = 0;
  do
  :: it < TASK_COUNT ->
     ix = 0;
     do
     :: ix < T[it].nr + T[it].ni ->
        if :: OF_SERVICE(it, ix) -> stop(it, ix) :: else -> skip fi;
        ix++
     :: else -> break
     od;
     it++
  :: else -> break
  od;
  wake_all(NONE)
}
inline advance() {
  if
  :: phase == STARTING ->
     collect_all();
     if
     :: failed -> kill()
     :: !failed && step + 1 == TASK_COUNT -> phase = RUNNING; step = 0
     :: else -> step++
     fi
  :: else ->
     if
     :: step == 0 -> phase = STOPPED
     :: else ->
        step--;
        if
        :: LISTED(step) > 0 ->
           ix = 0;
           do :: ix < LISTED(step) -> T[step].r[ix].asked = 1; ix++ :: else -> break od
        :: LISTED(step) == 0 && T[step].at != ABSENT && M_CODEL[step * STATES + STOP_STATE] != 0 ->
           send(step, step, 1)
        :: else -> skip
        fi;
        wake(step)
     fi
  fi
}

#define WORKS(t) (T[t].at != ABSENT && T[t].at != SLEEP && T[t].young == 0 && phase == RUNNING)
#ifdef TIME
#define MAY_TICK(t) (clock[t] == PERIOD[t])
#define MAY_RETURN(c) (since[c] >= LEAST[held[c] - 1])
#define TICKED(t) clock[t] = 0
#define OVERRUN(t) (clock[t] == PERIOD[t] && WORKS(t))
#else
#define MAY_TICK(t) (T[t].at == SLEEP)
#define MAY_RETURN(c) true
#define TICKED(t) skip
#define OVERRUN(t) false
#endif

/* Any of a node's answers. */
inline choose(n) {
  chosen = A_FIRST[n];
  do
  :: chosen + 1 < A_FIRST[n] + A_COUNT[n] -> chosen++
  :: break
  od
}

/* R1, R15: the start-up or the shutdown can take its next step. */
#define ADVANCES ((phase == STARTING && step < TASK_COUNT && T[step].at != ABSENT && T[step].young < 2) ||\
  (phase == STOPPING && step == TASK_COUNT && activities == 0 && nw == 0) ||\
  (phase == STOPPING && step < TASK_COUNT && LISTED(step) == 0))

proctype task(byte t) {
end:
  do
  :: d_step {                   /* R2 */
       phase != STOPPED && PERIOD[t] != 0 && MAY_TICK(t) ->
       TICKED(t);
       if
       :: T[t].at == ABSENT -> skip
       :: T[t].at == SLEEP -> T[t].at = BEGIN; T[t].tick = 1
       :: else -> T[t].late = 1
       fi
     }
  :: d_step {
       phase == STOPPING && PERIOD[t] != 0 && T[t].at == SLEEP && T[t].nr + T[t].ni > 0 ->
       T[t].at = BEGIN; T[t].tick = 1
     }
  :: d_step {
       phase != STOPPED && (T[t].at == BEGIN || (T[t].at == SLEEP && T[t].runnable)) -> begin(t); skip
     }
  :: d_step { phase != STOPPED && T[t].at == WAKE -> wake_all(t); rest(t); skip }
  :: atomic {
       held[t] != 0 && MAY_RETURN(t) ->
       choose(held[t] - 1);
       d_step { task_returns(t, A_KIND[chosen], A_TO[chosen]); chosen = 0 }
     }
  od
}
/* R9: what has ended is collected whatever else its task does. */
proctype collector(byte t) {
end:
  do
  :: d_step {
       phase != STOPPED && phase != STARTING && T[t].no > 0 -> collect_one(t); examine(); skip
     }
  od
}

proctype control() {
end:
  do
  :: d_step {                   /* R1 */
       TASK_COUNT > 0 && phase == STARTING && T[step].at == ABSENT ->
       send(step, step, 0); T[step].at = BEGIN; T[step].tick = 1
     }
  :: d_step { ADVANCES -> advance(); skip }
  :: d_step { SEVERAL_ENDED && phase != STOPPED && phase != STARTING -> collect_all(); skip }
  :: d_step { KILL && phase == RUNNING -> kill(); skip }
  :: KILL && phase == RUNNING && !(SEVERAL_ENDED) /* nobody has to ask */
  :: atomic { TOGETHER -> ENSURE(false) }   /* what excludes each other is executed */
  :: atomic { timeout -> ENSURE(phase == RUNNING || phase == STOPPED) }
  od
}

proctype service(byte s) {
end:
  do
  :: d_step {
       phase == RUNNING && nw < REQUESTS && pc[s] == 0 &&
       (S_MACHINE[s] == 0 || count[s] < INSTANCES) -> request(s); skip
     }
  :: phase == RUNNING && pc[s] == 0
  :: atomic {
       held[WORKER(s)] != 0 && MAY_RETURN(WORKER(s)) ->
       choose(held[WORKER(s)] - 1);
       d_step { worker_returns(s, A_KIND[chosen]); chosen = 0 }
     }
  :: d_step { phase != STOPPED && pc[s] >= WAKE_OK -> proceed(s); skip }
  od
}

/* Clients need not ask: fairness would let all of them do so again and again without such steps. */
#define NEED_NOT phase == RUNNING
#define MAY_ABORT (phase == RUNNING && nw < REQUESTS && pc[ABORTS] == 0)
/* R13: `abort_activity` of a pending activity, or of none. */
proctype abort_pending(byte at) {
end:
  do
  :: d_step {
       MAY_ABORT && (at == NONE || at < np) ->
       pc[ABORTS] = 1; nw++;
       if
       :: at == NONE -> finish(ABORTS, 0)
       :: else -> all_stay(); gone[at] = 1; drop_gone(1); examine(); finish(ABORTS, 1)
       fi; skip
     }
  :: NEED_NOT
  od
}
/* R13: of one that its task has. */
proctype abort_run(byte t; byte x) {
end:
  do
  :: d_step {
       MAY_ABORT && x < T[t].nr + T[t].ni && OF_SERVICE(t, x) && (T[t].r[x].life == INIT ||
         (x < T[t].nr && T[t].r[x].life == RUN && !T[t].r[x].asked && T[t].r[x].end == 0)) ->
       pc[ABORTS] = 1; nw++; stop(t, x); wake(t); examine(); finish(ABORTS, 1)
       skip
     }
  :: NEED_NOT
  od
}
/* The request itself, once its effect is there. */
proctype abort_ends() {
end:
  do
  :: d_step { phase != STOPPED && pc[ABORTS] >= WAKE_OK -> proceed(ABORTS); skip }
  od
}

/* R14 */
proctype event(byte t; byte k) {
end:
  do
  :: d_step {
       phase == RUNNING && !((T[t].fired >> k) & 1) && HEARS(t, k) ->
       T[t].fired = T[t].fired | (1 << k); wake(t)
     }
  :: NEED_NOT
  od
}
