/*
 * A middleware of genomd in a library of its own: `genomd --backend ./libgenomd_NAME.so`.
 *
 * The library exports one table, `genom_middleware_plugin`. genomd opens the library, compares the
 * version, and calls the functions of the table; the table `genom_mw_host` has what the library may
 * call. What crosses is bytes: a sample is a message in CDR (4 bytes of encapsulation, then XCDR1),
 * or, where the plugin wants that, the C layout of types of fixed size.
 *
 * Rules
 *   - Versions. A host refuses a plugin of another major version. Within one, structures only grow
 *     at their end: each begins with its size as its author knew it, and nobody reads beyond that.
 *     Set `size` to sizeof. Functions that a plugin does not have are NULL; those marked "required"
 *     are never.
 *   - Memory. Whoever allocates frees. Strings and bytes are lent for the time of the call: copy
 *     what is needed later. Strings are UTF-8 and not terminated.
 *   - Handles (genom_mw_backend, ...) belong to the plugin, which makes and frees them. The host uses
 *     one in one thread at a time, not always in the same one, except where a function says "any
 *     time", and closes all others of a backend before the backend itself.
 *   - What is given ("void *to") belongs to the host. Each is released once (`release`), at the
 *     latest when what it was given for has been closed and no thread of the plugin uses it any
 *     more; also where opening fails. From then on it is not used. `void *list` is lent for the call.
 *   - Threads. The functions of the host may be called from any thread, also from within a function
 *     of the plugin. They do not block, but `request` and `answer` may run code that opens and
 *     closes ends of this plugin: hold no lock there that those functions take.
 *   - Real time. Tasks of components never call a plugin, unless it sets GENOM_MW_RT_PUBLISH: the
 *     host has the queues, policies and threads.
 *   - Ends. No exception and no panic leaves a function, in either direction. A library is never
 *     unloaded.
 *
 * docs/plugins.md explains an example.
 */
#ifndef GENOM3_MIDDLEWARE_H
#define GENOM3_MIDDLEWARE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GENOM_MW_MAJOR 1
#define GENOM_MW_MINOR 2

typedef struct genom_mw_str { const char *ptr; size_t len; } genom_mw_str;
typedef struct genom_mw_bytes { const void *ptr; size_t len; } genom_mw_bytes;

/* A string literal as an initialiser: genom_mw_str name = GENOM_MW_STR("mine"); */
#define GENOM_MW_STR(literal) { literal, sizeof(literal) - 1 }

/* A port or service: component instance, and its port; "port/element" of a multiple port. */
typedef struct genom_mw_address { genom_mw_str instance, name; } genom_mw_address;

/* What functions return. The text that goes with it is in the last column. */
typedef int32_t genom_mw_code;
enum {
  GENOM_MW_OK = 0,
  GENOM_MW_FAILED = 1,        /* why, as all that are not listed here */
  GENOM_MW_TYPE_MISMATCH = 2, /* the type of the other side: name, size, digest */
  GENOM_MW_TAKEN = 3,         /* another publisher or server has the address */
  GENOM_MW_UNSUPPORTED = 4,   /* why this type or service cannot be carried */
  GENOM_MW_NOBODY = 5,        /* nobody serves the address */
  GENOM_MW_TIMEOUT = 6,       /* no answer within `value` nanoseconds */
  GENOM_MW_GONE = 7,          /* the service went away before it answered */
  GENOM_MW_BAD_DATA = 8       /* bytes that are no value of the type: why */
};

/* Filled by the callee when it returns another code than GENOM_MW_OK. May be NULL. */
typedef struct genom_mw_error {
  size_t size;
  char *text;     /* buffer of the caller, which has set `room`; cut there */
  size_t room;
  size_t len;     /* bytes written */
  uint64_t value; /* of GENOM_MW_TIMEOUT */
} genom_mw_error;

/* What a middleware can do (docs/backend.md). */
enum {
  GENOM_MW_VARIABLE = 1,        /* carries types with unbounded strings or sequences */
  GENOM_MW_CROSS_PROCESS = 2,   /* reaches other processes of this machine */
  GENOM_MW_CROSS_HOST = 4,      /* reaches other machines */
  GENOM_MW_SERVICES = 8,        /* serves and calls services: serve, client, ... are not NULL */
  GENOM_MW_NATIVE_SERVICES = 16,/* programs that are not genomd can call them */
  GENOM_MW_DISCOVERY = 32,      /* lists what exists: discover is not NULL */
  GENOM_MW_RT_PUBLISH = 64,     /* publish takes bounded time, without locks, allocation and
                                   blocking system calls: tasks call it themselves */
  GENOM_MW_LAYOUT = 128,        /* samples of fixed size cross in their C layout, not in CDR */
  GENOM_MW_NO_GATEWAY = 256,    /* nothing is gained from a process of its own: open it in the
                                   daemon unless the configuration says otherwise */
  GENOM_MW_RELAY = 512,         /* (1.2) passes requests between daemons: announce, ... are not
                                   NULL */
  GENOM_MW_REPORTS = 1024       /* (1.2) its tools show what components log, or how they fare: log
                                   or diagnose is not NULL */
};

enum { GENOM_MW_FIXED_SIZE = 1 };

typedef struct genom_mw_type {
  size_t size;
  genom_mw_str name;       /* ::demo::state */
  genom_mw_str digest;     /* two ends connect if their digests are equal, whatever the names */
  genom_mw_str definition; /* what it is made of, in JSON (docs/plugins.md) */
  uint64_t bytes;          /* size of the C layout */
  uint32_t align;
  uint32_t flags;          /* GENOM_MW_FIXED_SIZE: neither strings nor sequences without bound */
} genom_mw_type;

enum { GENOM_MW_LATEST = 0, GENOM_MW_QUEUE = 1, GENOM_MW_RING = 2 };

typedef struct genom_mw_port {
  size_t size;
  genom_mw_address at;
  const genom_mw_type *type;
  int32_t reliable;        /* 1, 0, or -1: as configured */
  int32_t transient_local; /* as reliable */
  int64_t depth;           /* samples of an out port that may wait, or -1 */
  uint32_t policy;         /* of a subscription; the host applies it */
  uint32_t keep;           /* samples that a queue or ring keeps */
} genom_mw_port;

enum { GENOM_MW_ATTRIBUTE = 0, GENOM_MW_FUNCTION = 1, GENOM_MW_ACTIVITY = 2 };

typedef struct genom_mw_service {
  size_t size;
  uint32_t kind;
  const genom_mw_type *input, *output;
  genom_mw_str digest;    /* caller and server must have the same */
  genom_mw_str described; /* its part of parameters and exceptions; may be empty */
} genom_mw_service;

/* What comes back for a request: an activity is accepted first, and may tell states. Of result,
   exception and lost there is exactly one, the last. */
enum {
  GENOM_MW_ACCEPTED = 1,  /* run: number of the activity */
  GENOM_MW_STATE = 2,     /* name: of the state that was entered */
  GENOM_MW_RESULT = 3,    /* data: the output, in CDR */
  GENOM_MW_EXCEPTION = 4, /* name: ::demo::TOO_FAR; data: its members in JSON, or empty */
  GENOM_MW_LOST = 5       /* code, with its text in name, and value */
};

typedef struct genom_mw_answer {
  size_t size;
  uint32_t what;
  genom_mw_code code;
  uint64_t run;
  uint64_t value;
  genom_mw_str name;
  genom_mw_bytes data;
} genom_mw_answer;

enum { GENOM_MW_LOG_ERROR = 1, GENOM_MW_LOG_WARN = 2, GENOM_MW_LOG_INFO = 3, GENOM_MW_LOG_DEBUG = 4 };
enum { GENOM_MW_OUT_PORT = 1, GENOM_MW_IN_PORT = 2, GENOM_MW_SERVICE = 3 };

/* Since version 1.2. */

/* An entry of a component's log. */
typedef struct genom_mw_entry {
  size_t size;
  genom_mw_str instance; /* the component */
  int64_t time;          /* nanoseconds since 1970 */
  uint32_t level;        /* GENOM_MW_LOG_ERROR, ... */
  uint32_t line;         /* from 1, or 0 where it is not known */
  genom_mw_str place;    /* what logged it: a module of the daemon */
  genom_mw_str file;     /* empty where it is not known */
  genom_mw_str message;
} genom_mw_entry;

/* A figure, by its name with unit. */
typedef struct genom_mw_pair { genom_mw_str name, value; } genom_mw_pair;

/* What of a component, and how it fares: it works as described, missed periods since it was told
   last, is in a codel that has not returned for too long, or ended although nobody had asked it to. */
enum { GENOM_MW_TASK = 1, GENOM_MW_CELL = 2 };
enum { GENOM_MW_GOOD = 1, GENOM_MW_LATE = 2, GENOM_MW_STUCK = 3, GENOM_MW_ENDED = 4 };

typedef struct genom_mw_diagnosis {
  size_t size;
  genom_mw_str instance; /* the component */
  uint32_t part;         /* a task of it, or the process (cell) that it is in */
  uint32_t health;
  genom_mw_str name;     /* of the task or cell */
  genom_mw_str message;  /* what, in a few words */
  const genom_mw_pair *values;
  size_t count;
} genom_mw_diagnosis;

typedef struct genom_mw_backend genom_mw_backend;           /* an open middleware */
typedef struct genom_mw_publisher genom_mw_publisher;       /* writing end of a port */
typedef struct genom_mw_subscription genom_mw_subscription; /* reading end of a port */
typedef struct genom_mw_served genom_mw_served;             /* a served service */
typedef struct genom_mw_call genom_mw_call;                 /* a request to it */
typedef struct genom_mw_client genom_mw_client;             /* calling end of a service */
typedef struct genom_mw_run genom_mw_run;                   /* a request that was made */
typedef struct genom_mw_announced genom_mw_announced;       /* (1.2) a daemon that others reach */
typedef struct genom_mw_relayed genom_mw_relayed;           /* (1.2) a request to that daemon */

/* What the host gives. The table stays valid for the life of the process. */
typedef struct genom_mw_host {
  size_t size;
  uint16_t major, minor;
  uint32_t flags;          /* none yet */
  void *host;
  /* Writes a line into the log of genomd. */
  void (*log)(void *host, uint32_t level, genom_mw_str text);
  /* Ends the use of what was given. */
  void (*release)(void *to);
  /* A sample arrived for a subscription; it is copied. */
  void (*sample)(void *to, genom_mw_bytes data);
  /* Somebody calls a served service. Answers come through `reply`, before this returns or later, and
     close_call is called once, when there will be no more. */
  void (*request)(void *to, genom_mw_call *call, genom_mw_bytes input);
  /* A caller cancels an activity of a served service, by the number of GENOM_MW_ACCEPTED. */
  void (*cancel)(void *to, uint64_t run);
  /* Answers a request of a client. If `to` is released without an end, the caller is told that the
     service went away. */
  void (*answer)(void *to, const genom_mw_answer *answer);
  /* Adds an entry to the list of `discover` and `ends_at`. `type` may be empty. */
  void (*endpoint)(void *list, uint32_t kind, genom_mw_str address, genom_mw_str type);
  /* Adds a pair to a list; see the functions that take one. */
  void (*text)(void *list, genom_mw_str key, genom_mw_str value);

  /* Since version 1.1. A host that calls `refused` has it. */

  /* Adds a reason to the list of `refused`: how often it was one so far, and the IP address of the
     peer that gave it last, as text, or an empty string. */
  void (*refusal)(void *list, genom_mw_str why, uint64_t count, genom_mw_str peer);

  /* Since version 1.2. A host that calls `announce` and `ask` has them. */

  /* A request arrived for an announced daemon; it is copied. There is one reply at most, through
     `reply_relayed`, before this returns or later, and close_relayed is called once, when there will
     be no more: at once for a request that comes after close_announced, is too large (64 MiB), or
     while 1024 others wait. */
  void (*relayed)(void *to, genom_mw_relayed *relayed, genom_mw_bytes request);
  /* Adds a reply to the list of `ask` and `ask_all`, with the identity of the end that sent it; it is
     copied. What comes after the function has returned, too much (16 replies, 128 MiB together) or
     too large (64 MiB) is left out. */
  void (*replied)(void *list, genom_mw_str from, genom_mw_bytes reply);
} genom_mw_host;

/* What the plugin gives. */
typedef struct genom_mw_plugin {
  size_t size;
  uint16_t major, minor;   /* GENOM_MW_MAJOR, GENOM_MW_MINOR */
  uint32_t reserved;       /* 0 */
  genom_mw_str name;       /* a to z, 0 to 9, _; begins with a letter; at most 32 */
  genom_mw_str version;    /* for people: "yarp 3.12" */
  uint64_t capabilities;

  /* Opens the middleware; required. `options`: its section [backends.NAME] as a JSON object. */
  genom_mw_code (*open)(const genom_mw_host *host, genom_mw_str options, genom_mw_backend **backend,
                        genom_mw_error *error);
  /* Closes it; required. */
  void (*close)(genom_mw_backend *backend);

  /* Opens the writing end of a port; required. It is visible to others at once, and keeps its last
     value for readers that come later, until it is closed. */
  genom_mw_code (*publisher)(genom_mw_backend *backend, const genom_mw_port *port,
                             genom_mw_publisher **publisher, genom_mw_error *error);
  /* Publishes a sample; required. May block: other ports are served meanwhile. Another code than
     GENOM_MW_OK counts the sample as lost. */
  genom_mw_code (*publish)(genom_mw_publisher *publisher, genom_mw_bytes sample);
  void (*close_publisher)(genom_mw_publisher *publisher); /* required */

  /* Opens the reading end of a port; required. Its writer may come later, leave and come back.
     The last value, if there is one, and each sample from then on go into `sample`, in order. */
  genom_mw_code (*subscription)(genom_mw_backend *backend, const genom_mw_port *port, void *to,
                                genom_mw_subscription **subscription, genom_mw_error *error);
  void (*close_subscription)(genom_mw_subscription *subscription); /* required */

  /* The rest may be NULL. */

  /* Capabilities of an open backend, if its options change them. */
  uint64_t (*capabilities_of)(genom_mw_backend *backend);
  /* How many samples were lost that `publish` took, or before they came to `sample`. Any time; does
     not block. */
  uint64_t (*lost_by_publisher)(genom_mw_publisher *publisher);
  uint64_t (*lost_by_subscription)(genom_mw_subscription *subscription);

  /* Serves a service: GENOM_MW_SERVICES needs all from here to close_client. */
  genom_mw_code (*serve)(genom_mw_backend *backend, genom_mw_address at,
                         const genom_mw_service *service, void *to, genom_mw_served **served,
                         genom_mw_error *error);
  void (*close_served)(genom_mw_served *served);
  /* The host answers a request. Any time, one at a time for a call. */
  void (*reply)(genom_mw_call *call, const genom_mw_answer *answer);
  /* No more answers come; if there was no end, the service is gone. */
  void (*close_call)(genom_mw_call *call);
  /* Opens the calling end. The service may come later, leave and come back. */
  genom_mw_code (*client)(genom_mw_backend *backend, genom_mw_address at,
                          const genom_mw_service *service, genom_mw_client **client,
                          genom_mw_error *error);
  /* Makes a request and returns; answers go into `answer` of the host, perhaps before this returns.
     `run` may be set to NULL if it cannot be cancelled. */
  genom_mw_code (*request)(genom_mw_client *client, genom_mw_bytes input, void *to,
                           genom_mw_run **run, genom_mw_error *error);
  /* Cancels an activity. Its end still comes as an answer. */
  void (*cancel)(genom_mw_run *run);
  /* Frees the handle; the request goes on. */
  void (*close_run)(genom_mw_run *run);
  void (*close_client)(genom_mw_client *client);

  /* Calls `endpoint` for all that is visible, of this process and of others; GENOM_MW_DISCOVERY
     needs it. Any time, as the other functions with a list. */
  genom_mw_code (*discover)(genom_mw_backend *backend, void *list, genom_mw_error *error);
  /* The same for one address; NULL: picked from `discover`. */
  genom_mw_code (*ends_at)(genom_mw_backend *backend, genom_mw_address at, void *list,
                           genom_mw_error *error);
  /* Calls `text` once, with the address as `discover` spells it as key; NULL: "instance/name". */
  void (*spelled)(genom_mw_backend *backend, genom_mw_address at, void *list);
  /* Peers that are connected but not listed: `text` with the name of a peer and its role, or with an
     address of ours that somebody reads and an empty value. */
  void (*strangers)(genom_mw_backend *backend, void *list);
  /* Why ends at an address do not connect: `text` with the cause, and what to do. */
  void (*obstacles)(genom_mw_backend *backend, genom_mw_address at, void *list);

  /* Shows a type or service as the middleware's own type `foreign` (#pragma masquerade) from now on,
     or no more. GENOM_MW_UNSUPPORTED: `foreign` is no name there; the text says how one looks. */
  genom_mw_code (*masquerade)(genom_mw_backend *backend, genom_mw_str ours, genom_mw_str foreign,
                              genom_mw_error *error);
  void (*unmask)(genom_mw_backend *backend, genom_mw_str ours);
  /* What a foreign program needs to find the ports: `text` with names and values. */
  void (*meeting_point)(genom_mw_backend *backend, void *list);

  /* Since version 1.1. Hosts of 1.0 do not call them. */

  /* Calls `refusal` once for each reason for which input of peers was refused since `open`. Does not
     block. */
  void (*refused)(genom_mw_backend *backend, void *list);
  /* What keeps this process from others on this middleware as a whole: `text` with the cause, and
     what to do. May take some seconds. */
  void (*trouble)(genom_mw_backend *backend, void *list);

  /* Since version 1.2. Hosts of 1.0 and 1.1 do not call them. */

  /* Requests between daemons, for clients that reach only one of the two: GENOM_MW_RELAY needs all
     from here to ask. The bytes are opaque; the daemons authenticate them. Any time, also several at
     once.

     Makes a daemon reachable under a name, and passes requests for that name to `relayed` with `to`.
     GENOM_MW_TAKEN: another daemon has that name. */
  genom_mw_code (*announce)(genom_mw_backend *backend, genom_mw_str name, void *to,
                            genom_mw_announced **announced, genom_mw_error *error);
  /* Withdraws it. Requests that wait may still be answered. */
  void (*close_announced)(genom_mw_announced *announced);
  /* The host answers a request. Any time, at most once; does not block. */
  void (*reply_relayed)(genom_mw_relayed *relayed, genom_mw_bytes reply);
  /* No reply comes any more: if there was none, who asked is told so. Does not block. */
  void (*close_relayed)(genom_mw_relayed *relayed);
  /* The daemons that are visible now, including this one: `text` with a name and an empty value. */
  genom_mw_code (*daemons)(genom_mw_backend *backend, void *list, genom_mw_error *error);
  /* The identity of this end: `text` once, with it as key. Those who ask get it with the replies of
     this end, and no two ends have the same. Does not block. */
  void (*own)(genom_mw_backend *backend, void *list);
  /* Sends a request to every end that serves that name, and calls `replied` for each reply. Returns
     when all have replied or closed the request, or after `patience` nanoseconds, which may be an
     hour. GENOM_MW_NOBODY: no daemon of that name is visible, also not a short time later. */
  genom_mw_code (*ask_all)(genom_mw_backend *backend, genom_mw_str name, genom_mw_bytes request,
                           uint64_t patience, void *list, genom_mw_error *error);
  /* Sends a request to the daemon of that name at one end, by its identity, and calls `replied` once.
     GENOM_MW_TIMEOUT: nothing came within `value` nanoseconds; GENOM_MW_GONE: the request was closed
     without a reply, or the end went away. */
  genom_mw_code (*ask)(genom_mw_backend *backend, genom_mw_str name, genom_mw_str at,
                       genom_mw_bytes request, uint64_t patience, void *list,
                       genom_mw_error *error);

  /* With GENOM_MW_REPORTS, shows an entry of a component's log, or how parts of components fare, in
     the middleware's own tools; what is about components that have no end open here is left out. A
     thread of the host calls both, one call at a time, also while it is in other functions. They may
     take time: reports wait meanwhile, and the newest are left out and counted if that takes too
     long. `parts` has `count` pointers. */
  void (*log)(genom_mw_backend *backend, const genom_mw_entry *entry);
  void (*diagnose)(genom_mw_backend *backend, const genom_mw_diagnosis *const *parts, size_t count);

  /* The time of components is that of a simulator, which tells it on this middleware. Called before
     anything is opened. */
  void (*simulated_time)(genom_mw_backend *backend);
} genom_mw_plugin;

#if defined(__GNUC__)
# define GENOM_MW_EXPORT __attribute__((visibility("default")))
#else
# define GENOM_MW_EXPORT
#endif

/* The one symbol that genomd looks for. */
extern GENOM_MW_EXPORT const genom_mw_plugin genom_middleware_plugin;

#ifdef __cplusplus
}
#endif

#endif /* GENOM3_MIDDLEWARE_H */
