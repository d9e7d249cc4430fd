using System;
using System.IO;
using System.IO.MemoryMappedFiles;
using System.Threading;

namespace OpenRoIS.Link
{
    /// <summary>Writes pictures into memory that is shared with the adapter, slot after slot.</summary>
    internal sealed unsafe class RingWriter : IDisposable
    {
        private readonly object _guard = new object();
        private readonly int _slots;
        private readonly int _slotBytes;
        private readonly MemoryMappedFile _file;
        private readonly MemoryMappedViewAccessor _view;
        private byte* _memory;
        private int _next;

        /// <exception cref="LinkException">It cannot be opened from here, or is not as large as was said.</exception>
        internal RingWriter(Welcome welcome)
        {
            _slots = welcome.Slots;
            _slotBytes = welcome.SlotBytes;
            long size = (long)_slots * _slotBytes;
            try
            {
                _file = MemoryMappedFile.CreateFromFile(
                    welcome.RingPath, FileMode.Open, null, 0, MemoryMappedFileAccess.ReadWrite);
                _view = _file.CreateViewAccessor(0, 0, MemoryMappedFileAccess.ReadWrite);
                if (_view.Capacity < size)
                {
                    throw new IOException($"it has {_view.Capacity} bytes, and {size} were announced");
                }
                _view.SafeMemoryMappedViewHandle.AcquirePointer(ref _memory);
                _memory += _view.PointerOffset;
            }
            catch (Exception error)
            {
                // Nothing depends on a ring: whatever this runtime cannot do for one, pictures go through the socket.
                _view?.Dispose();
                _file?.Dispose();
                throw new LinkException("the ring cannot be opened: " + error.Message, error);
            }
        }

        /// <summary>Write a picture into the next slot; its number, or -1 if it is too large for one.</summary>
        internal int Write(ulong sequence, byte* pixels, int size)
        {
            if (size > _slotBytes - Welcome.SlotHead)
            {
                return -1;
            }
            lock (_guard)
            {
                if (_memory == null)
                {
                    return -1;
                }
                int slot = _next;
                _next = (_next + 1) % _slots;
                byte* at = _memory + (long)slot * _slotBytes;
                Volatile.Write(ref *(ulong*)at, unchecked(2 * sequence + 1));
                // The pixels must not change before the lock word says so.
                Thread.MemoryBarrier();
                Buffer.MemoryCopy(pixels, at + Welcome.SlotHead, size, size);
                Volatile.Write(ref *(ulong*)at, unchecked(2 * sequence + 2));
                return slot;
            }
        }

        public void Dispose()
        {
            lock (_guard)
            {
                if (_memory != null)
                {
                    _memory = null;
                    _view.SafeMemoryMappedViewHandle.ReleasePointer();
                    _view.Dispose();
                    _file.Dispose();
                }
            }
        }
    }
}
