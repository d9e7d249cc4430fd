namespace OpenRoIS.Link
{
    /// <summary>How pixels are laid out; I420 and NV12 are BT.601 in limited range.</summary>
    public enum PixelFormat
    {
        Bgra = 1,
        I420 = 2,
        Nv12 = 3
    }

    /// <summary>The shape of a picture in memory.</summary>
    public struct Picture
    {
        private const int MinSide = 2;
        private const int MaxSide = 16384;

        public readonly int Width;
        public readonly int Height;

        /// <summary>Bytes of a row; in I420 of a row of Y.</summary>
        public readonly int Stride;

        public readonly PixelFormat Format;

        /// <summary>Whether the bottom row comes first, as in Unity's textures.</summary>
        public readonly bool BottomUp;

        /// <exception cref="LinkException">The link takes no such pictures.</exception>
        public Picture(int width, int height, int stride, PixelFormat format, bool bottomUp)
        {
            bool planar = format != PixelFormat.Bgra;
            CheckSides(width, height);
            if (planar && (width % 2 != 0 || height % 2 != 0 || stride % 2 != 0))
            {
                throw new LinkException("width, height and stride must be even in I420 and NV12");
            }
            if (stride < (planar ? width : 4 * width))
            {
                throw new LinkException("the stride is shorter than a row");
            }
            long size = planar ? (long)stride * height * 3 / 2 : (long)stride * height;
            if (size > Wire.MaxVideo - Wire.VideoHead)
            {
                throw new LinkException($"a picture of {size} bytes is over the limit of {Wire.MaxVideo}");
            }
            Width = width;
            Height = height;
            Stride = stride;
            Format = format;
            BottomUp = bottomUp;
        }

        internal static void CheckSides(int width, int height)
        {
            if (width < MinSide || width > MaxSide || height < MinSide || height > MaxSide)
            {
                throw new LinkException($"a picture of {width}x{height}: from {MinSide} to {MaxSide} is possible");
            }
        }

        /// <summary>Bytes of the pixels.</summary>
        public int Size
        {
            get { return Format == PixelFormat.Bgra ? Stride * Height : Stride * Height * 3 / 2; }
        }

        /// <summary>BGRA without padding.</summary>
        public static Picture Bgra(int width, int height, bool bottomUp)
        {
            return new Picture(width, height, 4 * width, PixelFormat.Bgra, bottomUp);
        }
    }
}
