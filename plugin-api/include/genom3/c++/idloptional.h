/*
 * optional<T> in C++: an aggregate, whose value exists even while it is absent.
 */
#ifndef GENOM3_CXX_IDLOPTIONAL_H
#define GENOM3_CXX_IDLOPTIONAL_H

namespace genom {

template <typename T> struct optional {
  bool _present;
  T _value;

  operator bool() const { return _present; }

  T &operator*() { return _value; }
  const T &operator*() const { return _value; }
  T *operator->() { return &_value; }
  const T *operator->() const { return &_value; }

  optional &operator=(const T &value) {
    _value = value;
    _present = true;
    return *this;
  }
  void reset() { _present = false; }
};

template <typename T> bool operator==(const optional<T> &a, const optional<T> &b) {
  return a._present == b._present && (!a._present || a._value == b._value);
}

template <typename T> bool operator!=(const optional<T> &a, const optional<T> &b) {
  return !(a == b);
}

}

#endif /* GENOM3_CXX_IDLOPTIONAL_H */
