/*
 * sequence<T, N> in C++: an array of N elements, the first `n` of which are valid.
 *
 * It is an aggregate, with the interface of std::array where that makes sense.
 */
#ifndef GENOM3_CXX_IDLSEQUENCE_H
#define GENOM3_CXX_IDLSEQUENCE_H

#include <algorithm>
#include <cstddef>
#include <stdexcept>

namespace genom {

template <typename T, std::size_t N> struct bounded_sequence {
  typedef T value_type;
  typedef T &reference;
  typedef const T &const_reference;
  typedef T *pointer;
  typedef const T *const_pointer;
  typedef T *iterator;
  typedef const T *const_iterator;
  typedef std::size_t size_type;
  typedef std::ptrdiff_t difference_type;

  T e[N];
  size_type n;

  iterator begin() { return e; }
  const_iterator begin() const { return e; }
  const_iterator cbegin() const { return e; }
  iterator end() { return e + n; }
  const_iterator end() const { return e + n; }
  const_iterator cend() const { return e + n; }

  size_type size() const { return n; }
  size_type max_size() const { return N; }
  size_type capacity() const { return N; }
  bool empty() const { return n == 0; }

  /* Elements that become valid again keep their last values. */
  void resize(size_type size) {
    if (size > N) throw std::out_of_range("genom::bounded_sequence::resize");
    n = size;
  }
  void clear() { n = 0; }
  void push_back(const T &value) {
    resize(n + 1);
    e[n - 1] = value;
  }
  void pop_back() { --n; }

  reference operator[](size_type i) { return e[i]; }
  const_reference operator[](size_type i) const { return e[i]; }
  reference at(size_type i) { return e[checked(i)]; }
  const_reference at(size_type i) const { return e[checked(i)]; }
  reference front() { return e[0]; }
  const_reference front() const { return e[0]; }
  reference back() { return e[n - 1]; }
  const_reference back() const { return e[n - 1]; }
  pointer data() { return e; }
  const_pointer data() const { return e; }

  void fill(const T &value) { std::fill(begin(), end(), value); }
  void swap(bounded_sequence &other) { std::swap(*this, other); }

private:
  /* A function only: an aggregate has no private data. */
  size_type checked(size_type i) const {
    if (i >= n) throw std::out_of_range("genom::bounded_sequence::at");
    return i;
  }
};

template <typename T, std::size_t N>
bool operator==(const bounded_sequence<T, N> &a, const bounded_sequence<T, N> &b) {
  return a.n == b.n && std::equal(a.begin(), a.end(), b.begin());
}

template <typename T, std::size_t N>
bool operator!=(const bounded_sequence<T, N> &a, const bounded_sequence<T, N> &b) {
  return !(a == b);
}

template <typename T, std::size_t N>
bool operator<(const bounded_sequence<T, N> &a, const bounded_sequence<T, N> &b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

}

#endif /* GENOM3_CXX_IDLSEQUENCE_H */
