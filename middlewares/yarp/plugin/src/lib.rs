//! The YARP backend as `libgenomd_yarp.so`, which `genomd --backend ./libgenomd_yarp.so` opens.
//! `docs/yarp.md` says what a YARP user finds.

genom_plugin::export!(genom_yarp::Yarp);
